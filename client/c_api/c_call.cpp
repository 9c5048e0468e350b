#include "client/c_api/c_call.hpp"

#include <poll.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "core/base/utf8.hpp"

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

std::int32_t not_open(const char* what) noexcept {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "the %s is null, or another process opened it", what);
  return fail(FW_ERROR_ARGUMENT, text.data());
}

std::uint32_t forks() noexcept { return forked.load(std::memory_order_relaxed); }

std::int32_t give_text(const std::optional<std::string>& found, char* to,
                       std::uint32_t size) noexcept {
  const std::string_view text = found ? std::string_view(*found) : std::string_view();
  // An empty text may have no bytes to point to.
  *std::copy_n(text.begin(), std::min<std::size_t>(text.size(), size - 1), to) = '\0';
  return found ? FW_OK : FW_NOTHING;
}

std::int32_t give_message(MessageQueue& messages, char* to, std::uint32_t size) noexcept {
  if (to == nullptr || size == 0) return fail(FW_ERROR_ARGUMENT, "text is null, or size is 0");
  return guarded([&] { return give_text(messages.next(), to, size); });
}

std::string text_of(const char* given, const std::string& name) {
  std::string text = given != nullptr ? given : "";
  if (!is_utf8(text)) throw std::invalid_argument(name + " is not text in UTF-8");
  return text;
}

std::int32_t wait_for_end(const Event& over, double timeout) noexcept {
  using Clock = std::chrono::steady_clock;
  constexpr double kMost = 1e6;  // [s]
  if (!(timeout >= 0.0)) return fail(FW_ERROR_ARGUMENT, "timeout must be 0 or more [s]");
  const auto latest = Clock::now() + std::chrono::nanoseconds(
                                         static_cast<std::int64_t>(1e9 * std::min(timeout, kMost)));
  pollfd waiting{over.descriptor(), POLLIN, 0};
  // A signal of the program may interrupt ppoll().
  for (auto now = Clock::now(); !over.is_set() && now < latest; now = Clock::now()) {
    const std::chrono::nanoseconds left = latest - now;
    const timespec time{static_cast<time_t>(left / std::chrono::seconds(1)),
                        static_cast<long>((left % std::chrono::seconds(1)).count())};
    ::ppoll(&waiting, 1, &time, nullptr);
  }
  return over.is_set() ? FW_ENDED : FW_NOTHING;
}

}  // namespace feltwire
