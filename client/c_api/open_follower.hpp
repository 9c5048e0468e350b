#pragma once
// A robot of a program that uses the library.

#include <atomic>
#include <future>
#include <string>
#include <thread>

#include "client/c_api/caller_robot.hpp"
#include "client/c_api/message_queue.hpp"
#include "client/followers/follower_loop.hpp"
#include "client/servo/event.hpp"

namespace feltwire {

/// The loop of feltwire-follower in a thread of its own. Any thread may use it.
class OpenFollower {
 public:
  /// Takes the seat. Throws as run_follower() does. `run` has no functions yet.
  OpenFollower(FollowerSpec robot, FollowerRun run);
  ~OpenFollower();
  OpenFollower(const OpenFollower&) = delete;
  OpenFollower& operator=(const OpenFollower&) = delete;

  CallerRobot& robot() noexcept { return robot_; }
  /// Returns the newest target in `target`; false: there is none yet. It never waits.
  bool latest(fw_robot_target& target) const noexcept;
  MessageQueue& messages() noexcept { return messages_; }
  void stop() noexcept { stop_.store(true); }
  const Event& over() const noexcept { return over_; }
  /// Ends the run, and waits for it. Returns the error that ended it too early; empty: none did.
  std::string end() noexcept;

 private:
  void run() noexcept;
  void has_joined();
  void has_lost(FollowerEnd end);
  std::string error_of(const FollowerResult& result) const;

  CallerRobot robot_;
  FollowerRun run_;
  MessageQueue messages_;
  std::atomic<bool> stop_{false};
  Event over_;
  std::promise<void> joined_;
  // Members of the thread.
  bool was_joined_ = false, connected_ = false;
  std::string error_;  // any thread may read it once `over_` is set
  std::thread thread_;
};

}  // namespace feltwire
