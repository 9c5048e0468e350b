#include "tests/support/hurry.hpp"

#include <atomic>
#include <cerrno>
#include <ctime>

namespace {
constinit std::atomic<int> hurries = 0;
}  // namespace

namespace feltwire::test {
Hurry::Hurry() { ++hurries; }
Hurry::~Hurry() { --hurries; }
}  // namespace feltwire::test

// The linker prefers the program's function to libc's. sleep_for() calls this function.
extern "C" int nanosleep(const timespec* time, timespec* left) {
  constexpr long kFaster = 10;
  const timespec less{.tv_sec = 0,
                      .tv_nsec = (time->tv_sec * 1000000000L + time->tv_nsec) / kFaster};
  const bool hurried = hurries.load() > 0 && time->tv_sec < kFaster;
  const int error = ::clock_nanosleep(CLOCK_MONOTONIC, 0, hurried ? &less : time, left);
  if (error == 0) return 0;
  errno = error;
  return -1;
}
