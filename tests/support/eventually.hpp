#pragma once
// The one way in which tests wait for what another thread or process does: with a limit, and with a
// failure that names what did not come.

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

namespace feltwire::test {

/// Far longer than anything here takes, on a loaded machine or under a sanitizer as well.
inline constexpr std::chrono::seconds kLongest{60};

/// Asks until it is so; false when it was not for as long as `longest`.
template <class Condition>
bool becomes(Condition condition, std::chrono::nanoseconds longest = kLongest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Waits for it. Where it does not come, the test fails at the line of the caller and ends.
template <class Condition>
void eventually(const std::string& what, Condition condition,
                std::chrono::nanoseconds longest = kLongest, const char* file = __builtin_FILE(),
                int line = __builtin_LINE()) {
  if (becomes(condition, longest)) return;
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(longest).count();
  const std::string message = what + ": not within " + std::to_string(waited) + " ms";
  // Said at once, for the exception may be the end of the program: a thread may still be running.
  ADD_FAILURE_AT(file, line) << message;
  throw std::runtime_error(message);
}

}  // namespace feltwire::test
