#pragma once
// A thread that asks the server for what the views of a scene lack.

#include <poll.h>

#include <functional>
#include <thread>
#include <utility>

#include "client/servo/event.hpp"

namespace feltwire {

/// Waits until the event is set or the time [ms] is over.
inline void wait_for(const Event& event, int time) {
  pollfd waiting{event.descriptor(), POLLIN, 0};
  ::poll(&waiting, 1, time);
}

/// Queries the server in its own thread, so that a slow answer does not delay a picture. The
/// destructor ends the thread.
class QueryThread {
 public:
  /// `ask` returns soon after its argument was set.
  explicit QueryThread(std::function<void(const Event& over)> ask)
      : thread_([this, ask = std::move(ask)] { ask(over_); }) {}
  ~QueryThread() {
    over_.set();
    thread_.join();
  }
  QueryThread(const QueryThread&) = delete;
  QueryThread& operator=(const QueryThread&) = delete;

 private:
  Event over_;
  std::thread thread_;
};

}  // namespace feltwire
