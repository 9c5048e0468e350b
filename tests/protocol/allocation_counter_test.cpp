// The allocation tests use this counter. The counter must include the heap uses of all libraries.

#include "tests/support/allocation_counter.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <thread>

namespace feltwire::allocation_counter_test {
namespace {

// The compiler may remove unused memory. This variable prevents the removal.
void* volatile looked_at = nullptr;

/// Returns the number of heap uses of `work`.
template <class Work>
std::size_t uses(const Work& work) {
  const std::size_t before = test::allocations();
  work();
  return test::allocations() - before;
}

class AllocationCounter : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef FELTWIRE_SANITIZED
    GTEST_SKIP() << "a sanitizer brings its own malloc";
#endif
  }
};

TEST_F(AllocationCounter, SeesEveryWayToTakeMemoryAndToGiveItBack) {
  const auto takes_and_frees = [](auto take) {
    return uses([&] {
      looked_at = take();
      std::free(looked_at);
    });
  };
  EXPECT_EQ(takes_and_frees([] { return std::malloc(10); }), 2u);
  EXPECT_EQ(takes_and_frees([] { return std::calloc(2, 10); }), 2u);
  EXPECT_EQ(takes_and_frees([] { return std::realloc(nullptr, 10); }), 2u);
  EXPECT_EQ(takes_and_frees([] { return ::reallocarray(nullptr, 2, 10); }), 2u);
  EXPECT_EQ(takes_and_frees([] { return std::aligned_alloc(64, 128); }), 2u);
  EXPECT_EQ(takes_and_frees([] {
              void* memory = nullptr;
              EXPECT_EQ(::posix_memalign(&memory, 64, 100), 0);
              return memory;
            }),
            2u);
  EXPECT_EQ(uses([] {
              looked_at = new double(1.0);
              delete static_cast<double*>(looked_at);
            }),
            2u);
  struct alignas(128) Wide {
    double value[16];
  };
  EXPECT_EQ(uses([] {
              looked_at = new Wide{};
              delete static_cast<Wide*>(looked_at);
            }),
            2u);
  EXPECT_EQ(uses([] { std::free(nullptr); }), 0u);
  EXPECT_EQ(uses([] {}), 0u);
}

TEST_F(AllocationCounter, SeesLibraries) {
  EXPECT_EQ(uses([] { looked_at = ::strdup("a copy that libc makes"); }), 1u);
  std::free(looked_at);
  EXPECT_GT(uses([] { looked_at = EVP_CIPHER_CTX_new(); }), 0u);  // libcrypto
  EXPECT_GT(uses([] { EVP_CIPHER_CTX_free(static_cast<EVP_CIPHER_CTX*>(looked_at)); }), 0u);
  // Every library must use the malloc of this program.
  for (const char* name :
       {"malloc", "calloc", "realloc", "free", "aligned_alloc", "memalign", "posix_memalign"}) {
    Dl_info in_use{}, own{};
    ASSERT_NE(::dladdr(::dlsym(RTLD_DEFAULT, name), &in_use), 0) << name;
    ASSERT_NE(::dladdr(reinterpret_cast<void*>(&test::allocations), &own), 0);
    EXPECT_EQ(in_use.dli_fbase, own.dli_fbase) << name << " is that of " << in_use.dli_fname;
  }
}

TEST_F(AllocationCounter, CountsEachThreadByItself) {
  std::size_t in_thread = 0;
  std::thread thread([&] {
    in_thread = uses([] {
      looked_at = ::strdup("elsewhere");
      std::free(looked_at);
    });
  });
  const std::size_t before = test::allocations(), others = test::allocations_of_others();
  thread.join();
  EXPECT_EQ(in_thread, 2u);
  EXPECT_LE(test::allocations(), before + 1);  // Only the thread's own memory is freed.
  EXPECT_GE(test::allocations_of_others(), 2u);
  EXPECT_GE(test::allocations_of_others(), others);
}

TEST_F(AllocationCounter, MemoryIsAsAskedFor) {
  for (const std::size_t alignment : {16u, 64u, 4096u}) {
    looked_at = std::aligned_alloc(alignment, alignment);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(looked_at) % alignment, 0u);
    std::free(looked_at);
  }
  void* memory = nullptr;
  EXPECT_EQ(::posix_memalign(&memory, 3, 100), EINVAL);
  volatile std::size_t too_many = SIZE_MAX;  // volatile hides the value from the compiler
  EXPECT_EQ(::reallocarray(nullptr, too_many, 2), nullptr);
  EXPECT_EQ(errno, ENOMEM);
  auto* const zeros = static_cast<unsigned char*>(std::calloc(100, 10));
  looked_at = zeros;
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(zeros[i], 0);
  std::free(looked_at);
}

}  // namespace
}  // namespace feltwire::allocation_counter_test
