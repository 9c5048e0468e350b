// Takes arbitrary bytes from a robot's driver. Each line must be refused with a field and a remedy,
// or give possible values.

#include "client/followers/follower_lines.hpp"

#include <cstring>

#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

using namespace feltwire::follower_lines;

bool possible(const Pose& pose) {
  return pose.position.allFinite() && pose.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
         std::abs(pose.orientation.norm() - 1.0) < 1e-9;
}

void look_at(std::string_view line) {
  FollowerSpec spec;
  if (const auto fault = read_hello(line, spec))
    require(!fault->what.empty(), "a fault says what it is");
  else
    require(spec.stiffness > 0.0 && spec.servo_period > 0.0 && !spec.name.empty(),
            "a hello has what a follower needs");
  std::uint64_t number = 0;
  FollowerReading reading;
  if (const auto fault = read_state(line, number, reading)) {
    require(!fault->what.empty(), "a fault says what it is");
    return;
  }
  require(possible(reading.pose) && possible(reading.commanded), "poses are possible");
  require(reading.velocity.allFinite() && reading.torque.allFinite() &&
              reading.angular_velocity.allFinite() &&
              reading.force.value_or(Vec3::Zero()).allFinite(),
          "a reading is finite");
  require(reading.gripper >= 0.0 && reading.gripper_force >= 0.0, "a gripper is possible");
  // The target line for this reading must be valid.
  std::array<char, kLongestLine> text{};
  const std::size_t size = write_target(number, {reading.commanded, reading.gripper}, text);
  require(size > 0 && text[size - 1] == '\n', "a target is a line");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  using namespace feltwire::fuzz;
  follower_lines::Lines lines;
  Input input(data, size);
  std::uint64_t last = 0;
  while (!input.empty()) {
    const std::span<char> room = lines.room();
    require(!room.empty(), "there is always room");
    const Bytes bytes = input.bytes(std::min<std::size_t>(room.size(), 1 + input.byte()));
    std::memcpy(room.data(), bytes.data(), bytes.size());
    lines.added(bytes.size());
    while (const auto line = lines.next()) {
      require(line->number > last, "lines are counted upwards");
      require(line->text.size() <= follower_lines::kLongestLine, "lines are bounded");
      last = line->number;
      if (!line->too_long) look_at(line->text);
    }
  }
  return 0;
}
