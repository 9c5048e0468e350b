// Takes arbitrary bytes as answers of a Falcon's firmware. The result must be no answer, or encoder
// counts as published and a tool at the end of the legs. The motors must be able to give forces
// there.

#include <vector>

#include "client/drivers/novint/falcon_board.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

using namespace falcon;

// [m] from the published facts, not from the driver
constexpr double kArm = 0.060, kShin = 0.1025, kToolAlong = 0.01443, kJoint = 0.01125,
                 kToolAcross = -0.025, kBaseAlong = 0.0400, kBaseAcross = -0.02309;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<double, 3> kLegs = {105.0 * kDegree, -15.0 * kDegree, -135.0 * kDegree};

/// Decodes four letters from 'A' to 'P' in little-endian order and two's complement.
int number(const std::uint8_t* letters) {
  constexpr int kHalf = 1 << 15;
  int value = 0, weight = 1;
  for (int n = 0; n < 4; ++n, weight *= 16) {
    require(letters[n] >= 'A' && letters[n] <= 'P', "a number is of letters");
    value += (letters[n] - 'A') * weight;
  }
  return value < kHalf ? value : value - 2 * kHalf;
}

/// Returns true if the packet is an answer of the firmware.
bool is_answer(const Packet& packet) {
  if (packet[0] != '<' || packet[15] != '>') return false;
  for (std::size_t n = 1; n <= 12; ++n)
    if (packet[n] < 'A' || packet[n] > 'P') return false;
  return packet[13] >= 'A' && packet[13] - 'A' < 128;
}

/// Returns an answer of homed legs with possible arm angles, and some beyond.
std::vector<std::uint8_t> possible_answer(Input& input) {
  constexpr int kRange = 8192;  // counts, about 300 degrees
  std::vector<std::uint8_t> bytes = {'<'};
  for (int i = 0; i < 3; ++i) {
    const unsigned count =
        static_cast<unsigned>(input.whole<std::uint16_t>() % kRange - kRange / 2);
    for (unsigned n = 0; n < 4; ++n)
      bytes.push_back(static_cast<std::uint8_t>('A' + count / (1U << (4 * n)) % 16));
  }
  for (const int byte : {'A' + 0x70, int{'A'}, int{'>'}})
    bytes.push_back(static_cast<std::uint8_t>(byte));
  return bytes;
}

/// Adds the bytes in two pieces.
std::optional<BoardReply> answer_of(Bytes bytes, std::size_t first) {
  Answer answer;
  answer.add(bytes.first(std::min(first, bytes.size())));
  answer.add(bytes.subspan(std::min(first, bytes.size())));
  const bool begins = !bytes.empty() && bytes[0] == '<';
  require(answer.whole() == (begins && bytes.size() == kPacket), "an answer is whole");
  require(answer.garbled() == ((!bytes.empty() && !begins) || bytes.size() > kPacket),
          "what is no answer is garbled");
  if (!answer.whole()) return std::nullopt;
  const Packet& packet = answer.packet();
  require(std::equal(packet.begin(), packet.end(), bytes.begin()), "an answer is what came");
  const auto all = parse_reply(packet);
  require(all.has_value() == is_answer(packet), "an answer has the published form");
  if (!all) return std::nullopt;
  const int extra = packet[13] - 'A';
  for (std::size_t i = 0; i < 3; ++i) {
    require(all->encoders[i] == number(&packet[1 + 4 * i]), "encoders are the published numbers");
    require(all->homed[i] == (extra / (16 << i) % 2 == 1), "a leg is homed by its bit");
  }
  require(all->buttons == static_cast<unsigned>(extra % 16), "buttons are four bits");
  return all;
}

/// Checks that the tool is at the end of all three shins, not far from the middle.
void look_at(const ToolPoint& tool, const Counts& encoders) {
  const Vec3& p = tool.position;
  require(p.allFinite() && tool.jacobian.allFinite(), "a place is finite");
  require((p - kMiddle).norm() < 0.1, "a place is one that legs reach");
  require(tool.jacobian.cwiseAbs().maxCoeff() * kCount < 0.5e-3, "a count is a small movement");
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = (35.0 + encoders[i] * 360.0 / (4.0 * 320.0) * 14.25 / 110.0) * kDegree;
    const double phi = kLegs[i];
    const double u = p.x() * std::cos(phi) + p.y() * std::sin(phi) - kBaseAlong + kToolAlong;
    const double v = p.y() * std::cos(phi) - p.x() * std::sin(phi) - kBaseAcross + kToolAcross;
    const double shin = 2.0 * kJoint + kShin * std::sin(std::acos(v / kShin));
    const double gap = std::hypot(u - kArm * std::cos(t), p.z() - kArm * std::sin(t)) - shin;
    require(std::abs(gap) < 1e-9, "the legs meet at the tool");
  }
}

/// Checks the driver's request for this force, and the force that the motors hold.
void push(const ToolPoint& tool, const Vec3& force, std::uint8_t extra) {
  const Counts motors = motors_of(tool, force);
  constexpr std::array kLights = {Light::none, Light::red, Light::green, Light::blue};
  const Light light = kLights[extra % kLights.size()];
  const bool homes = extra >= 128;
  const Packet sent = request(motors, light, homes);
  require(sent[0] == '<' && sent[14] == 'A' && sent[15] == '>', "a request has its frame");
  require(sent[13] == 'A' + static_cast<int>(light) + (homes ? 1 : 0), "and its lights");
  for (std::size_t i = 0; i < 3; ++i) {
    require(std::abs(motors[i]) <= kMostMotor, "a motor is told no more than it may get");
    require(number(&sent[1 + 4 * i]) == motors[i], "a request has the motors' numbers");
  }
  if (!force.allFinite()) require(motors == Counts{}, "a force that is no number is not given");
  if (motors == Counts{}) return;
  const Vec3 held = force_of(tool, motors);
  require(held.allFinite(), "a held force is finite");
  // Rounding changes each motor's count by less than one.
  require(held.norm() <= force.norm() + 0.15, "no more is held than was asked for");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  using namespace feltwire::fuzz;
  constexpr double kMostForce = 40.0;  // [N] above the force of any device
  Input input(data, size);
  falcon::TrackedTool tool;
  Nanoseconds now(0);
  while (!input.empty()) {
    const std::uint8_t how = input.byte();
    const std::size_t first = how % 16U;
    const std::size_t more = how / 16 == 1 ? 1U : 0U, fewer = how / 16 == 2 ? 1U : 0U;
    std::vector<std::uint8_t> made;
    if (how >= 128) made = possible_answer(input);
    const auto all =
        answer_of(how >= 128 ? made : input.bytes(falcon::kPacket + more - fewer), first);
    now += std::chrono::microseconds(input.whole<std::uint16_t>());
    if (!all || how / 16 == 3) {
      tool.forget();
      continue;
    }
    const falcon::ToolPoint before = tool.point();
    if (tool.take(all->encoders, now)) {
      look_at(tool.point(), all->encoders);
      falcon::TrackedTool fresh;
      require(!fresh.take(all->encoders, now) ||
                  (fresh.point().position - tool.point().position).norm() < 1e-9,
              "a place does not depend on the places before");
    } else {
      require(same(before.position, tool.point().position), "what is refused changes nothing");
    }
    const std::uint8_t extra = input.byte();
    const bool any = extra % 128 >= 64;
    const double x = any ? input.any_double() : input.number(kMostForce);
    push(tool.point(), Vec3(x, input.number(kMostForce), input.number(kMostForce)), extra);
  }
  return 0;
}
