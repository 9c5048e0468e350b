#pragma once
// The messages for people that a program has not taken yet.

#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace feltwire {

/// Any thread may use it. Where too many wait, the oldest is lost.
class MessageQueue {
 public:
  void keep(std::string message) {
    const std::lock_guard lock(mutex_);
    if (messages_.size() == kMost) messages_.pop_front();
    messages_.push_back(std::move(message));
  }
  /// The oldest message; empty: there is none.
  std::optional<std::string> next() {
    const std::lock_guard lock(mutex_);
    if (messages_.empty()) return std::nullopt;
    std::string oldest = std::move(messages_.front());
    messages_.pop_front();
    return oldest;
  }

 private:
  static constexpr std::size_t kMost = 64;
  std::mutex mutex_;
  std::deque<std::string> messages_;
};

}  // namespace feltwire
