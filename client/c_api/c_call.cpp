#include "client/c_api/c_call.hpp"

#include <pthread.h>

#include <atomic>

namespace feltwire {
namespace {

constexpr std::size_t kErrorRoom = 1024;
/// Numbers only: a thread that ends has nothing to destroy.
thread_local std::array<char, kErrorRoom> thread_error{};

std::atomic<std::uint32_t> forked{0};
/// A call of the system for the process's number would take longer than all else in a getter.
[[maybe_unused]] const int registered =
    ::pthread_atfork(nullptr, nullptr, [] { forked.fetch_add(1, std::memory_order_relaxed); });

}  // namespace

std::int32_t fail(std::int32_t result, const char* text) noexcept {
  std::strncpy(thread_error.data(), text, thread_error.size() - 1);
  thread_error.back() = '\0';
  // The text is a single line, without signs that would change a terminal.
  for (char& sign : thread_error)
    if (sign != '\0' && static_cast<unsigned char>(sign) < ' ') sign = ' ';
  return result;
}

const char* last_error() noexcept { return thread_error.data(); }

std::uint32_t forks() noexcept { return forked.load(std::memory_order_relaxed); }

void write_text(std::string_view from, char* to, std::uint32_t size) noexcept {
  // An empty text may have no bytes to point to.
  *std::copy_n(from.begin(), std::min<std::size_t>(from.size(), size - 1), to) = '\0';
}

}  // namespace feltwire
