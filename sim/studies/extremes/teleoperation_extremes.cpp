#include "sim/studies/extremes/teleoperation_extremes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/base/splitmix.hpp"
#include "core/teleoperation/follower_servo.hpp"
#include "core/teleoperation/two_port_bound.hpp"

namespace feltwire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kRobotSamples = 4000;
constexpr double kLimitRounding = 1e-9;  // of a limit; a sample has some hundred operations

/// The extreme quantities of one run of a robot.
struct RobotStress {
  std::string name;
  double stiffness = 1000.0;   // [N/m] of the robot's controller
  double surface = 1e4;        // [N/m] of the wall that it touches
  double period = 1e-3;        // [s]
  Vec3 place = Vec3::Zero();   // [m] where the robot begins; the wall is 5 mm ahead on x
  double assumed_scale = 1.0;  // as in ExtremeMatrix
  Nanoseconds begin{0};        // time of the first sample
  std::uint64_t first_target = 1;
  /// The target of a sample; by default it swings by 20 mm into the wall and back.
  std::function<Vec3(int sample, const Vec3& usual)> target{};
  std::function<double(int sample)> hand_work{};
  std::function<void(int sample, FollowerReading& reading)> spoil{};
};

/// The columns of a run.
struct RobotCells {
  ExtremeCell leash, speed, touch, workspace, estimate;
};

ExtremeCell robot_cell(const RobotStress& stress, const char* judged, const char* reference) {
  return {
      .stress = stress.name, .judged = judged, .reference = reference, .allowed = kLimitRounding};
}

/// [m] The place at which a robot rests whose controller holds `target`: before the wall, or in it.
double resting_place(const RobotStress& stress, double target, double wall) {
  if (target <= wall) return target;
  return wall + (target - wall) * stress.stiffness / (stress.stiffness + stress.surface);
}

RobotCells run_robot(const RobotStress& stress) {
  constexpr double kWallAhead = 5e-3, kSwing = 20e-3, kBack = 0.5;  // [m]
  constexpr double kTurns = 0.005;                                  // [rad] a sample
  RobotCells cells{
      robot_cell(stress, "leash", "force of the controller's spring beyond the leash, relative"),
      robot_cell(stress, "speed", "movement of the target beyond the speed limit, relative"),
      robot_cell(stress, "first", "force before the hand knows of the contact, beyond the limit"),
      robot_cell(stress, "workspace", "target behind a wall, over half a metre"),
      robot_cell(stress, "estimate", "length of the normal against one")};
  FollowerOptions options;
  options.workspace.add({Vec3::UnitX(), stress.place.x() - kBack});
  FollowerSpec spec;
  spec.stiffness = stress.stiffness;
  spec.servo_period = stress.period;
  FollowerServo servo(spec, options);
  const double wall = stress.place.x() + kWallAhead;
  // A place has this rounding, and a stiff spring makes a force of it.
  const double digit = 8.0 * kEpsilon * (length(stress.place) + 1.0);  // [m]

  Vec3 held = stress.place, tip_before = stress.place;
  for (int n = 0; n < kRobotSamples; ++n) {
    const Nanoseconds now = stress.begin + from_seconds(n * stress.period);
    RobotTarget target;
    target.index = stress.first_target + static_cast<std::uint64_t>(n);
    target.state = LinkState::engaged;
    target.pose.position = stress.place + Vec3(kSwing * std::sin(kTurns * n), 0.0, 0.0);
    if (stress.target) target.pose.position = stress.target(n, target.pose.position);
    target.hand_work = stress.hand_work ? stress.hand_work(n) : 0.0;
    servo.take(target, now);

    FollowerReading reading;
    reading.pose.position = held;
    reading.pose.position.x() = resting_place(stress, held.x(), wall);
    const Vec3 tip = reading.pose.position;
    reading.velocity = (tip - tip_before) / stress.period;
    reading.force = Vec3(-stress.surface * std::max(0.0, tip.x() - wall), 0.0, 0.0);
    reading.commanded.position = held;
    if (stress.spoil) stress.spoil(n, reading);
    const bool usable = reading.pose.position == tip;

    const FollowerTarget wanted = servo.step(reading, now);
    const RobotState& state = servo.report(wanted);
    const Vec3 next = wanted.pose.position;
    const bool finite = next.allFinite() && wanted.pose.orientation.coeffs().allFinite();
    const double stretched = length(Vec3(next - tip));
    const double force = stress.stiffness * stretched;
    const double force_digit = stress.stiffness * digit;
    if (usable)
      cells.leash.judge(
          finite,
          std::max(0.0, (force - force_digit) / (options.leash / stress.assumed_scale) - 1.0));
    const double way = length(Vec3(next - held)), robot_way = length(Vec3(tip - tip_before));
    // The clock has nanoseconds. After a sample that is not usable the next one is longer.
    const double time = (stress.spoil ? 10.0 : 1.0) * stress.period + 2e-9;
    const double most = options.motion.speed * time / stress.assumed_scale + robot_way + digit;
    cells.speed.judge(finite, std::max(0.0, way / most - 1.0));
    const bool unknown = state.ok && state.contact.touching && state.contact.surface != 0;
    if (unknown && usable)
      cells.touch.judge(finite, std::max(0.0, (force - force_digit) / options.first_touch - 1.0));
    cells.workspace.judge(finite,
                          std::max(0.0, (stress.place.x() - kBack - digit - next.x()) / kBack));
    const RemoteContact& contact = state.contact;
    cells.estimate.judge(contact.point.allFinite() && contact.normal.allFinite() &&
                             contact.velocity.allFinite() && std::isfinite(contact.stiffness),
                         std::abs(length(contact.normal) - 1.0),
                         contact.surface == 0 || contact.stiffness > 0.0);
    tip_before = tip;
    if (finite) held = next;
  }
  // The robot must have moved, unless its targets were all impossible.
  if (!stress.target && !stress.spoil && length(Vec3(held - stress.place)) == 0.0)
    ++cells.leash.holes;
  return cells;
}

std::vector<RobotStress> robot_stresses() {
  std::vector<RobotStress> all;
  for (const double stiffness : {1e-3, 1.0, 1e3, 1e6, 1e9})
    all.push_back({.name = stress_name("robot", stiffness, "N/m"), .stiffness = stiffness});
  for (const double surface : {1e-3, 1.0, 1e6, 1e9})
    all.push_back({.name = stress_name("surface", surface, "N/m"), .surface = surface});
  for (const double period : {10.0, 0.1, 1e-5, 1e-6})
    all.push_back({.name = stress_name("rate", 1.0 / period, "Hz"), .period = period});
  for (const double far : {1e3, 1e6})
    all.push_back({.name = stress_name("robot at", far, "m"), .place = Vec3(far, -far, far)});
  all.push_back({.name = "target at 1e6 m", .target = [](int n, const Vec3&) {
                   return Vec3(Vec3::Constant(n % 200 < 100 ? 1e6 : -1e6));
                 }});
  all.push_back({.name = "target NaN; Inf; 1e300", .target = [](int n, const Vec3& usual) {
                   constexpr std::array kStrange = {kNan, kInfinity, -kInfinity, 1e300, -1e200};
                   Vec3 target = usual;
                   target[n % 3] = kStrange[static_cast<std::size_t>(n) % kStrange.size()];
                   return n % 7 == 0 ? usual : target;
                 }});
  all.push_back({.name = "hand work NaN; Inf; 1e300", .hand_work = [](int n) {
                   constexpr std::array kStrange = {kNan,   kInfinity, 1e300,
                                                    -1e300, 0.0,       -kInfinity};
                   return kStrange[static_cast<std::size_t>(n) % kStrange.size()];
                 }});
  all.push_back({.name = "readings NaN; Inf; 1e6 m", .spoil = [](int n, FollowerReading& reading) {
                   constexpr std::array kStrange = {kNan, kInfinity, 1e300, 1e6, -kInfinity};
                   const double strange = kStrange[static_cast<std::size_t>(n) % kStrange.size()];
                   if (n % 50 == 7) reading.pose.position[n % 3] = strange;
                   if (n % 50 == 17) reading.force = Vec3(strange, 0.0, 1.0);
                   if (n % 50 == 27) reading.velocity.y() = strange;
                 }});
  all.push_back({.name = "index up to 2^64 - 1",
                 .first_target = std::numeric_limits<std::uint64_t>::max() - kRobotSamples});
  all.push_back({.name = "time up to 2^63 ns",
                 .begin = Nanoseconds::max() - from_seconds((kRobotSamples + 1) * 1e-3)});
  return all;
}

/// A number from 0 to 1, the draw `i` of a seed.
double share_of(std::uint64_t seed, std::uint64_t i) {
  return static_cast<double>(splitmix::draw(seed, i) >> 11) * 0x1p-53;
}

/// A hand that takes as much energy from the port as it can, or moves at random: what it takes
/// beyond the device's damping and the remote's energy, over all that was exchanged.
ExtremeCell run_two_port(const std::string& stress, double damping, double period, double most_move,
                         double most_force, bool strange_inputs) {
  ExtremeCell cell{.stress = stress,
                   .judged = "two-port",
                   .reference = "energy missing of the promise, over all exchanged",
                   .allowed = 64.0 * kEpsilon};
  TwoPortBound bound(damping, period);
  long double delivered = 0.0L, burned = 0.0L, exchanged = 0.0L, largest_remote = 0.0L;
  double remote = 0.0;
  Vec3 held = Vec3::Zero();
  for (int n = 0; n < kRobotSamples; ++n) {
    const auto draw = [&](std::uint64_t i) { return share_of(n + 1, i); };
    TwoPortBound::Sample sample;
    sample.hold_time = period;
    // The greediest movement while `held` acts, or one at random.
    sample.displacement = draw(0) < 0.5
                              ? Vec3(held * (period / (2.0 * damping)))
                              : Vec3(most_move * Vec3(draw(1) - 0.5, draw(2) - 0.5, draw(3) - 0.5));
    if (!(length(sample.displacement) <= most_move)) sample.displacement.setZero();
    sample.command = most_force * Vec3(draw(4) - 0.5, draw(5) - 0.5, draw(6) - 0.5);
    remote += draw(7) < 0.3 ? most_force * most_move * (draw(8) - 0.5) : 0.0;
    sample.remote = remote;
    largest_remote = std::max(largest_remote, static_cast<long double>(remote));
    const long double given = held.cast<long double>().dot(sample.displacement.cast<long double>());
    delivered += given;
    const long double lost = static_cast<long double>(damping) / static_cast<long double>(period) *
                             sample.displacement.cast<long double>().squaredNorm();
    burned += lost;
    exchanged += std::abs(given) + lost;
    if (strange_inputs && draw(9) < 0.05) {
      constexpr std::array kStrange = {kNan, kInfinity, -kInfinity, 1e300};
      const double strange = kStrange[splitmix::draw(n + 1, 10) % kStrange.size()];
      const std::array<double*, 3> inputs = {&sample.displacement.x(), &sample.command.y(),
                                             &sample.remote};
      *inputs[splitmix::draw(n + 1, 11) % inputs.size()] = strange;
      if (std::isfinite(sample.remote))
        largest_remote = std::max(largest_remote, static_cast<long double>(sample.remote));
    }
    held = bound.step(sample);
    const long double missing = delivered - burned - largest_remote;
    const long double error = std::max(0.0L, missing) / std::max(exchanged, 1e-300L);
    cell.judge(held.allFinite(), static_cast<double>(error),
               !(length(held) > most_force * (1.0 + kLimitRounding)));
  }
  return cell;
}

}  // namespace

ExtremeMatrix run_teleoperation_extremes(double assumed_scale) {
  ExtremeMatrix matrix{.part = "teleoperation",
                       .title = "worst excess over a limit, as a share of the limit",
                       .assumed_scale = assumed_scale};
  for (RobotStress stress : robot_stresses()) {
    stress.assumed_scale = assumed_scale;
    try {
      RobotCells cells = run_robot(stress);
      // A robot that meets nothing has no first touch.
      for (ExtremeCell* cell :
           {&cells.leash, &cells.speed, &cells.touch, &cells.workspace, &cells.estimate})
        if (cell != &cells.touch || cell->checks > 0) matrix.cells.push_back(std::move(*cell));
    } catch (const std::invalid_argument& error) {
      ExtremeCell cell = robot_cell(stress, "leash", "");
      cell.refused = error.what();
      matrix.cells.push_back(std::move(cell));
    }
  }
  for (const double damping : {1e-6, 0.5, 1e6})
    for (const double period : {1e-5, 1e-3, 0.1})
      matrix.cells.push_back(
          run_two_port(stress_name("damping", damping, "N s/m") + stress_name("; T", period, "s"),
                       damping, period, 1e-3, 10.0, false));
  for (const double force : {1e-300, 1e-9, 1e9, 1e12})
    matrix.cells.push_back(
        run_two_port(stress_name("force", force, "N"), 0.5, 1e-3, 1e-3, force, false));
  for (const double move : {1e-300, 1e-9, 1e3, 1e6})
    matrix.cells.push_back(
        run_two_port(stress_name("movement", move, "m"), 0.5, 1e-3, move, 10.0, false));
  matrix.cells.push_back(run_two_port("NaN; Inf; 1e300", 0.5, 1e-3, 1e-3, 10.0, true));
  return matrix;
}

}  // namespace feltwire
