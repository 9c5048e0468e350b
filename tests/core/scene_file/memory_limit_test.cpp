// A process with little memory must report this. No library below the loader may end the process by
// a signal.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <new>
#include <string>

#include "core/scene_file/load_scene.hpp"

namespace feltwire::memory_limit_test {
namespace {

constexpr std::size_t kMegabyte = 1000000;

std::size_t address_space() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

using Load = std::function<void()>;

/// Loads a scene in a process that may use `more` additional bytes of address space, and exits. The
/// status is 0 if the scene is loaded, 1 if the error mentions memory, and 3 otherwise.
[[noreturn]] void load_with(std::size_t more, const Load& load) {
  const rlimit limit{address_space() + more, RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
  int status = 0;
  try {
    load();
  } catch (const std::bad_alloc&) {  // No memory is left even for the text of the error.
    status = 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    status = std::strstr(error.what(), "memor") != nullptr ? 1 : 3;
  }
  _exit(status);
}

/// Returns a scene of many boxes with a tree.
std::string boxes() {
  std::string text = R"({"name":"many","materials":[{"name":"m","stiffness":1000}],"objects":[)";
  for (int i = 0; i < 2000; ++i)
    text += (i > 0 ? R"(,{"name":"b)" : R"({"name":"b)") + std::to_string(i) +
            R"(","box":{"size":[1,1,1]},"position":[)" + std::to_string(2 * i) +
            R"(,0,0],"material":"m"})";
  return text + "]}";
}

/// Raises the limit until the scene has loaded a few times. With `little`, the first limit is too
/// small.
void load_within_limits(const Load& load, bool little) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer reserves more address space than any limit here";
#endif
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // Each test runs in its own process.
  int refused = 0, loaded = 0;
  const auto ended = [&](int status) {
    loaded += WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 1 : 0;
    refused += WIFEXITED(status) && WEXITSTATUS(status) == 1 ? 1 : 0;
    return WIFEXITED(status) && WEXITSTATUS(status) <= 1;
  };
  for (std::size_t more = 0; more <= 600 && loaded < 3; more += more < 24 ? 2 : 12)
    ASSERT_EXIT(load_with(more * kMegabyte, load), ended, "") << more << " MB";
  EXPECT_EQ(loaded, 3);
  if (little) {
    EXPECT_GT(refused, 0);
  }
  std::cout << refused << " limits refused\n";
}

Load file(const char* name) {
  return [path = std::string(FELTWIRE_SOURCE_DIR "/scenes/") + name] { load_scene(path); };
}

TEST(MemoryLimit, OfASceneWithATree) {
  load_within_limits([text = boxes()] { parse_scene(text, "boxes.json"); }, true);
}
TEST(MemoryLimit, OfAMesh) { load_within_limits(file("bunny.json"), true); }
TEST(MemoryLimit, OfBodies) { load_within_limits(file("workshop.json"), false); }
TEST(MemoryLimit, OfAToolWithABody) { load_within_limits(file("body.json"), false); }

}  // namespace
}  // namespace feltwire::memory_limit_test
