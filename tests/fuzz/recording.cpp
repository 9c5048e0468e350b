// Takes arbitrary text as a recorded movement. The result must be an error with its place, or a
// movement of finite poses.

#include <sstream>

#include "client/hands/replay_device.hpp"
#include "core/base/csv.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

void require_pose(const Recording& recording, double time, std::size_t& cursor) {
  const Pose pose = pose_at(recording, time, cursor);
  require(pose.position.allFinite(), "every instant has a finite position");
  require(std::abs(pose.orientation.norm() - 1.0) < 1e-6, "every instant has a unit orientation");
}

void play(const Recording& recording) {
  constexpr int kBetween = 4;
  const auto& poses = recording.poses;
  require(!poses.empty(), "a recording has poses");
  std::size_t cursor = 0;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    require(poses[i].time < poses[i + 1].time, "time rises");
    for (int n = 0; n <= kBetween; ++n)
      require_pose(recording, poses[i].time + n * ((poses[i + 1].time - poses[i].time) / kBetween),
                   cursor);
  }
  require_pose(recording, poses.front().time - 1.0, cursor);
  require_pose(recording, poses.back().time + 1.0, cursor);

  ReplayDevice device(recording, builtin_device("simulated"));
  for (const std::int64_t now : {0L, 1L, 1'000'000L, 1'000'000'000L, 4'000'000'000'000'000'000L})
    require(device.read(Nanoseconds(now)).pose.position.allFinite(), "the device is somewhere");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  try {
    std::istringstream in(fuzz::text(data, size));
    fuzz::play(read_recording(in, "rows.csv"));
  } catch (const CsvError& error) {
    fuzz::require_place(error.what(), "rows.csv");
  }
  return 0;
}
