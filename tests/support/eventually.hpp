#pragma once
// The only way in which tests wait for another thread or process: with a limit, and with a failure
// that names the missing event.

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

namespace feltwire::test {

/// Far longer than any wait here takes, even on a loaded machine or under a sanitizer.
inline constexpr std::chrono::seconds kLongest{60};

/// Polls the condition; false if it stays false for `longest`.
template <class Condition>
bool becomes(Condition condition, std::chrono::nanoseconds longest = kLongest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Waits for the condition. If it stays false, the test fails at the caller's line and ends.
template <class Condition>
void eventually(const std::string& what, Condition condition,
                std::chrono::nanoseconds longest = kLongest, const char* file = __builtin_FILE(),
                int line = __builtin_LINE()) {
  if (becomes(condition, longest)) return;
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(longest).count();
  const std::string message = what + ": not within " + std::to_string(waited) + " ms";
  // Report at once: the exception may end the program while another thread still runs.
  ADD_FAILURE_AT(file, line) << message;
  throw std::runtime_error(message);
}

}  // namespace feltwire::test
