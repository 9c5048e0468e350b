#pragma once
// The recording of a robot that follows: each of its samples as a line of a file.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "core/base/line_file.hpp"
#include "core/base/ring.hpp"
#include "core/teleoperation/robot.hpp"

namespace feltwire {

/// FILE.csv with these columns, in the robot's frame:
///   t           [s] since the first sample
///   x,y,z       [m] the tool; qw,qx,qy,qz its orientation
///   fx,fy,fz    [N] of the environment on the tool; empty where it is not sensed
///   cx,cy,cz    [m] the target that its controller holds
///   stiffness   [N/m] of its spring and the surface that it touches, in series; 0: none
///   sample      of the hand's, counted from 1, that the newest target comes from; 0: none
///   state       of the link, as the newest target says it
/// A thread of its own writes the file, so that the robot's loop never waits for the disk.
class FollowerRecord {
 public:
  /// Creates or replaces the file. Throws std::runtime_error naming it and the reason.
  explicit FollowerRecord(const std::filesystem::path& file);
  ~FollowerRecord();
  FollowerRecord(const FollowerRecord&) = delete;
  FollowerRecord& operator=(const FollowerRecord&) = delete;

  /// Adds a sample; the robot's loop calls it. It never waits: a row without room is counted.
  void add(const RobotState& said, const RobotTarget& target) noexcept;

  /// Writes the rest. Throws std::runtime_error if the file is incomplete.
  void finish();

  std::uint64_t dropped() const noexcept { return dropped_.load(); }

 private:
  struct Row {
    Nanoseconds time{0};
    Pose pose;
    std::optional<Vec3> force;
    Vec3 commanded = Vec3::Zero();
    double stiffness = 0.0;
    std::uint64_t sample = 0;
    LinkState state = LinkState::disabled;
  };
  void write();
  void write_until(const std::stop_token& end) noexcept;
  static void append_row(std::string& lines, const Row& row, double time);

  LineFile file_;
  Ring<Row> rows_;
  std::optional<Nanoseconds> first_;
  std::atomic<std::uint64_t> dropped_{0};
  std::string error_;    // of the writing thread; empty: none
  std::jthread writer_;  // the last member: it uses the others
};

}  // namespace feltwire
