#include "client/c_api/open_follower.hpp"

#include <exception>
#include <utility>

#include "protocol/net/clock.hpp"

namespace feltwire {

OpenFollower::OpenFollower(FollowerSpec robot, FollowerRun run)
    : robot_(std::move(robot)), run_(std::move(run)) {
  run_.on_join = [this] { has_joined(); };
  run_.on_loss = [this](FollowerEnd end) { has_lost(end); };
  run_.on_sample = [this](const RobotState& said, const RobotTarget& newest) {
    robot_.publish(said, newest, connected_);
  };
  thread_ = std::thread([this] { this->run(); });
  try {
    joined_.get_future().get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

OpenFollower::~OpenFollower() { end(); }

bool OpenFollower::latest(fw_robot_target& target) const noexcept {
  if (!robot_.latest(target, monotonic_now())) return false;
  if (over_.is_set()) target.connected = 0;
  return true;
}

void OpenFollower::run() noexcept {
  try {
    const FollowerResult result = run_follower(robot_, run_, stop_);
    error_ = error_of(result);
  } catch (const std::exception& error) {
    if (was_joined_)
      error_ = error.what();
    else
      joined_.set_exception(std::current_exception());
  }
  over_.set();
}

void OpenFollower::has_joined() {
  connected_ = true;
  if (was_joined_)
    messages_.keep("the robot has its seat again");
  else
    joined_.set_value();
  was_joined_ = true;
}

void OpenFollower::has_lost(FollowerEnd end) {
  connected_ = false;
  messages_.keep(std::string(end == FollowerEnd::evicted ? "the server ended the robot's session"
                                                         : "the server has fallen silent") +
                 "; the robot stays at its place" +
                 (run_.patience > 0.0 ? ", and asks for its seat again" : ""));
}

std::string OpenFollower::error_of(const FollowerResult& result) const {
  if (result.end == FollowerEnd::requested) return {};
  const std::string what = result.end == FollowerEnd::evicted
                               ? "the server ended the robot's session"
                               : "the server has fallen silent; is it still running?";
  return result.refusal.empty() ? what : what + ": " + result.refusal;
}

std::string OpenFollower::end() noexcept {
  stop();
  if (thread_.joinable()) thread_.join();
  return std::move(error_);
}

}  // namespace feltwire
