#include "client/hands/replay_device.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "core/base/csv.hpp"
#include "core/base/file_error.hpp"
#include "core/base/foreign_content.hpp"
#include "core/base/regular_file.hpp"
#include "core/device/possible_movement.hpp"

namespace feltwire {
namespace {

constexpr double kLatest = 1e10;  // [s] largest valid time; a larger time has too few digits
constexpr double kNotUnit =
    0.01;  // tolerance of the quaternion norm, above the rounding of printed digits

/// Returns for each row whether the pose jumps to the next row. Compares the times of the
/// recording. The servo's ticks are unsuitable: a long tick would hide a jump, and a short tick
/// would turn every row into a jump.
std::vector<bool> jumps_of(const Recording& recording, const DeviceSpec& spec) {
  const auto& poses = recording.poses;
  std::vector<bool> jumps(poses.size());
  PossibleMovement moves(position_bounds(spec)), turns(rotation_bounds(spec));
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const auto& [time, pose] = poses[i];
    const auto& [later, next] = poses[i + 1];
    const bool moved = moves.made(next.position - pose.position, later - time);
    const bool turned =
        turns.made(rotation_between(pose.orientation, next.orientation), later - time);
    jumps[i] = !moved || !turned;
  }
  return jumps;
}

}  // namespace

Recording read_recording(std::istream& in, const std::string& file) {
  CsvReader reader(in, file, {"t", "x", "y", "z"}, {"qw", "qx", "qy", "qz"});
  Recording recording;
  recording.rotation = reader.has("qw");
  for (const char* column : {"qw", "qx", "qy", "qz"}) {
    if (reader.has(column) != recording.rotation)
      reader.fail(reader.has(column) ? "qw" : column,
                  "it is missing while others of qw,qx,qy,qz are there; give all four or none");
  }
  std::array<double, 8> row{0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  while (reader.next(row)) {
    const auto& [t, x, y, z, qw, qx, qy, qz] = row;
    if (!(std::abs(t) <= kLatest))
      reader.fail("t", "it is beyond +-1e10 s; give the time in seconds");
    for (const auto& [column, value] : {std::pair{"x", x}, {"y", y}, {"z", z}})
      if (!(std::abs(value) <= kMaxPosition))
        reader.fail(column,
                    "it is more than 1000 m from the origin, where no hand is; give metres");
    if (!recording.poses.empty() && !(t > recording.poses.back().time))
      reader.fail("t", "time must rise from row to row; sort the rows and drop repeated ones");
    Quaternion orientation(qw, qx, qy, qz);
    if (!(std::abs(orientation.norm() - 1.0) < kNotUnit))
      reader.fail("qw", "qw,qx,qy,qz have length " + std::to_string(orientation.norm()) +
                            ", not 1; normalize the quaternion");
    orientation.normalize();
    recording.poses.push_back({t, {Vec3(x, y, z), orientation}});
  }
  if (recording.poses.empty())
    reader.fail("", "there are no rows below the header; record something");
  return recording;
}

Recording read_recording(const std::filesystem::path& file, std::string_view remedy) {
  // [bytes] More than an hour of rows at 1 kHz.
  constexpr std::size_t kLargest = std::size_t{512} << 20;
  std::istringstream in = [&] {
    try {
      std::string text = read_regular_file(file, kLargest, remedy);
      if (const auto foreign = foreign_content(text))
        throw CsvError(file.string() + ": " + *foreign);
      return std::istringstream(std::move(text));
    } catch (const FileError& error) {
      throw CsvError(error.what());
    }
  }();
  return read_recording(in, file.string());
}

Pose pose_at(const Recording& recording, double time, std::size_t& cursor) noexcept {
  const auto& poses = recording.poses;
  if (!(time > poses.front().time)) return poses.front().pose;
  if (time >= poses.back().time) return poses.back().pose;
  if (poses[cursor].time > time) cursor = 0;
  while (poses[cursor + 1].time <= time) ++cursor;

  const RecordedPose& before = poses[cursor];
  const RecordedPose& after = poses[cursor + 1];
  const double share = (time - before.time) / (after.time - before.time);
  Pose pose;
  pose.position = before.pose.position + share * (after.pose.position - before.pose.position);
  pose.orientation = before.pose.orientation.slerp(share, after.pose.orientation);
  return pose;
}

ReplayDevice::ReplayDevice(Recording recording, const DeviceSpec& spec,
                           std::optional<double> leads_from)
    : recording_(std::move(recording)), spec_(spec), leads_from_(leads_from) {
  spec_.rotation_sensed = recording_.rotation ? 3 : 0;
  if (!recording_.rotation) {
    spec_.rotation_actuated = 0;
    spec_.max_torque = 0.0;
  }
  jumps_after_ = jumps_of(recording_, spec_);
  jumps_ = static_cast<std::size_t>(std::ranges::count(jumps_after_, true));
}

DeviceReading ReplayDevice::read(Nanoseconds now) noexcept {
  if (!started_) start_ = now;
  started_ = true;
  const double passed = std::chrono::duration<double>(now - start_).count();
  const double time = recording_.poses.front().time + passed;
  const std::size_t before = cursor_;
  const Pose pose = pose_at(recording_, time, cursor_);
  // Include the jumps of all rows since the last reading.
  bool jumped = false;
  for (std::size_t row = std::min(before + 1, cursor_); row <= cursor_; ++row)
    jumped |= jumps_after_[row];
  return {.pose = pose,
          .ended = time >= recording_.poses.back().time,
          .deadman = leads_from_ && passed >= *leads_from_,
          .jumped = jumped};
}

std::unique_ptr<Device> make_replay_device(const std::filesystem::path& file,
                                           const DeviceSpec& spec,
                                           std::optional<double> leads_from) {
  return std::make_unique<ReplayDevice>(read_recording(file, "check the path behind 'replay:'"),
                                        spec, leads_from);
}

}  // namespace feltwire
