#include "sim/studies/teleop/arm_bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "client/hands/hand_device.hpp"
#include "client/simulated_robots/arm.hpp"
#include "core/base/numeric.hpp"
#include "core/base/parallel.hpp"
#include "core/base/text.hpp"
#include "core/dynamics/unpacked_files.hpp"
#include "scenes/arm/arm_text.hpp"
#include "scenes/arm/box_text.hpp"
#include "scenes/arm/peg_text.hpp"
#include "scenes/arm/sphere_text.hpp"
#include "scenes/arm/table_text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/teleop/bench.hpp"
#include "sim/studies/teleop/bench_energy.hpp"
#include "sim/studies/teleop/minimum_jerk.hpp"
#include "sim/studies/teleop/one_way_link.hpp"
#include "sim/teleoperation_laws/remote_ends.hpp"

namespace feltwire::teleop::with_arm {
namespace {

constexpr double kTable = 0.3, kTableStiffness = 5000.0;  // [m] height, [N/m]: scenes/arm/table.xml
constexpr double kTableFriction = 0.3;              // friction coefficient mu, from the same file
constexpr double kBoxMass = 0.15, kBoxHigh = 0.22;  // [kg], [m] height: scenes/arm/box.xml
constexpr double kOpen = 0.08, kGrips = 0.03;       // [m] gripper opening: open, on the box
constexpr double kPegWide = 0.02, kPegLong = 0.04;  // [m] width, half length: scenes/arm/peg.xml
constexpr double kBlock = 0.33;                     // [m] top of the block with the hole
constexpr double kGripperSpeed = 0.1;               // [m/s] speed limit of the gripper
// [m] From scenes/arm/sphere.xml and arm.xml: radius of the ball, radius of a finger tip, distance
// of the finger tips from the plane of the movement.
constexpr double kBall = 0.1, kTip = 0.007, kTips = 0.012;
const Vec3 kBallAt(0.45, 0.0, 0.3);  // [m] centre of the ball
constexpr Hand kHand{.mass = 0.1, .damping = 5.0, .stiffness = 300.0};

/// The hand's intended position [m] and opening of the gripper [m], at a given time.
struct Meant {
  Vec3 place = Vec3::Zero();
  double gripper = 0.0;
};

/// Returns an intention on a path from 20 mm above the top of the table to 40 mm below it. `down`:
/// fraction of this path.
Meant into_table(double down) {
  constexpr double kAbove = 0.02, kWay = 0.06;  // [m] start height; length of the path
  return {{0.45, 0.0, kTable + kAbove - kWay * down}, 0.0};
}
Meant press(double t) { return into_table(eased(0.5, 3.5, t)); }
/// Returns the intention: press, rise, and press a second time.
Meant again(double t) {
  return into_table(eased(0.5, 3.5, t) - eased(4.5, 7.5, t) + eased(7.5, 10.5, t));
}
/// Returns the intention: press, then slide 80 mm along the table.
Meant slide(double t) {
  constexpr double kWay = 0.08;  // [m]
  Meant meant = press(t);
  meant.place.x() += kWay * std::clamp((t - 5.0) / 3.0, 0.0, 1.0);
  return meant;
}
/// Returns the intention: move from 20 mm above a ball to 30 mm below its surface, then 40 degrees
/// around its center in 8 s.
Meant sphere(double t) {
  constexpr double kAbove = 0.02, kInside = 0.03;  // [m]
  constexpr double kHalfWay = 20.0 / 180.0 * std::numbers::pi;
  const double angle = kHalfWay * (2.0 * std::clamp((t - 4.0) / 8.0, 0.0, 1.0) - 1.0);
  const double radius = kBall + kAbove - (kAbove + kInside) * eased(0.5, 3.5, t);
  return {kBallAt + radius * Vec3(std::sin(angle), 0.0, std::cos(angle)), 0.0};
}
/// Returns the intention: move the peg (20 mm wide) to a point above the hole (20.5 mm wide), then
/// down until 30 mm are in the hole. The path ends 0.5 mm beside the axis of the hole in x and in
/// y.
Meant peg(double t) {
  const Vec3 home(0.306891, 0.0, 0.475);  // [m] start position in scenes/arm/peg.xml
  constexpr double kBeside = 5e-4, kGripsPeg = 0.01, kOver = 0.02, kInto = 0.03;  // [m]
  const Vec3 over(0.45 + kBeside, kBeside, kBlock + kPegLong + kOver);
  Vec3 place = home + eased(0.5, 4.0, t) * (over - home);
  place.z() -= (kOver + kInto) * eased(4.5, 10.5, t);
  return {place, kGripsPeg};
}
/// Returns the intention: move down to the box, grip it, lift it by 60 mm, put it back and release
/// it.
Meant lift(double t) {
  constexpr double kAbove = 0.055, kDown = 0.05, kUp = 0.06;  // [m]
  const double height =
      kAbove - kDown * eased(0.5, 1.5, t) + kUp * (eased(2.5, 4.0, t) - eased(7.5, 13.5, t));
  return {{0.45, 0.0, kBoxHigh + height}, t > 1.7 && t < 14.0 ? kGrips : kOpen};
}

struct Task {
  std::string_view name;
  const char* scene;  // name of the scene file, and of the body that the arm carries
  Meant (*meant)(double time);
  double duration, from, until;        // [s] the time from `from` to `until` is measured
  std::optional<double> presses = {};  // [s] start of a press that lasts kPressesFor
  double opening = 0.0;                // [m] initial opening of the gripper
};
constexpr double kPressesFor = 3.0;  // [s] duration of a press
constexpr std::array kTasks = {Task{"press", "table", press, 6.0, 4.5, 6.0, 0.5},
                               Task{"again", "table", again, 12.5, 11.0, 12.5, 7.5},
                               Task{"slide", "table", slide, 8.0, 6.0, 7.9, 0.5},
                               Task{"sphere", "sphere", sphere, 12.0, 6.0, 11.9, 0.5},
                               Task{"lift", "box", lift, 15.0, 6.0, 7.4, {}, kOpen},
                               Task{"peg", "peg", peg, 12.0, 11.0, 12.0, {}, kPegWide}};

const Task& task_of(const std::string& name) {
  const auto* const found = std::ranges::find(kTasks, name, &Task::name);
  if (found == kTasks.end())
    throw std::invalid_argument("the bench of the arm has no task '" + name +
                                "'; give press, again, slide, sphere, lift or peg");
  return *found;
}

class MeaningHand final : public HandDevice {
 public:
  MeaningHand(const DeviceSpec& spec, const Task& task) : HandDevice(spec, kHand), task_(task) {
    place(task.meant(0.0).place);
  }

 private:
  Vec3 intended(double time) noexcept override { return task_.meant(time).place; }
  const Task& task_;
};

DeviceSpec device(const Plant& plant) {
  DeviceSpec spec;
  spec.name = "hand";
  spec.damping = Damping(plant.leader_damping);
  spec.apparent_mass = plant.leader_mass;
  spec.position_resolution = plant.leader_quantum;
  spec.max_force = plant.leader_force;
  return spec;
}

struct ArmSample {
  Vec3 shown = Vec3::Zero();    // [m] hand position, from the encoder
  Vec3 held = Vec3::Zero();     // [N] force on the hand from this sample on
  Vec3 contact = Vec3::Zero();  // [N] contact force on the tool
  Vec3 offset = Vec3::Zero();   // [m] leader's offset: position of the hand minus target
  double height = 0.0;          // [m] height of the tool
  Vec3 thing = Vec3::Zero();    // [m] position of the box or the peg
  double pushed = 0.0;          // [J] energy that the contacts gave to the robot
  double stiffness = 0.0;       // [N/m] surface stiffness that the leader knows; 0: none
};

std::vector<ArmSample> run(const ArmCase& c, const Task& task, const UnpackedFiles& scenes,
                           bool& stopped) {
  ArmConfig config;
  config.file = scenes.place(std::string(task.scene) + ".xml");
  config.gripper = task.opening;
  config.seed = c.seed;
  Arm arm(config);
  Plant plant;
  plant.stiffness = arm.spec().stiffness;
  plant.wrench_noise = arm.spec().wrench_noise;
  plant.period = arm.spec().servo_period;
  Nanoseconds start{0};
  const Meant first = task.meant(0.0);
  FollowerTarget target = bring(arm, first.place, first.gripper, start);
  MeaningHand hand(device(plant), task);
  RemoteLeader leader(plant);
  RemoteFollower follower(plant);
  LinkOptions link;
  constexpr double kHalf = 0.5;
  link.delay = kHalf * c.round_trip;
  link.jitter = c.jitter;
  link.loss = c.loss;
  link.keep_order = false;
  OneWayLink<LeaderState> forth(link, link_key(c.seed, 0, LinkDirection::up));
  OneWayLink<FollowerState> back(link, link_key(c.seed, 0, LinkDirection::down));
  const double smooth = 1.0 - std::exp(-2.0 * std::numbers::pi * kVelocityCutoff * plant.period);
  std::optional<LeaderState> wanted;
  FollowerState seen;
  std::optional<Vec3> before;
  Vec3 velocity = Vec3::Zero();
  std::vector<ArmSample> samples;
  const auto count = static_cast<std::uint64_t>(std::llround(task.duration / plant.period));
  samples.reserve(count);
  for (std::uint64_t n = 0; n < count; ++n) {
    const double now = static_cast<double>(n) * plant.period;
    // Leader: the hand and its device.
    const Vec3 at = hand.read(from_seconds(now)).pose.position;
    velocity += smooth * (moved(before, at) / plant.period - velocity);
    for (const FollowerState& state : back.receive(now)) {
      leader.take(state.energy);
      if (state.index >= seen.index) seen = state;
    }
    const Vec3 force = leader.step(at, velocity, seen.contact, seen.others, now - seen.time);
    Command command;
    command.elastic = force;
    hand.write(command);
    forth.send({n, at - leader.offset(), leader.known_surface(), leader.hand_work(),
                task.meant(now).gripper},
               now);
    // Follower: the arm.
    const FollowerReading reading = arm.read(start + from_seconds(now));
    follower.step(reading.pose.position, reading.velocity, reading.force.value_or(Vec3::Zero()));
    for (const LeaderState& state : forth.receive(now))
      if (!wanted || state.index >= wanted->index) wanted = state;
    if (wanted) {
      target.pose.position = follower.target(*wanted);
      const double most = kGripperSpeed * plant.period;
      target.gripper += std::clamp(wanted->gripper - target.gripper, -most, most);
      arm.write(target);
    }
    back.send({n, now, follower.contact(), follower.others(), follower.energy()}, now);
    stopped = stopped || reading.stopped || !reading.ok;
    samples.push_back({at, force, arm.contact_force(), leader.offset(), reading.pose.position.z(),
                       arm.place_of(task.scene).value_or(Vec3::Zero()), follower.energy().pushed,
                       seen.contact.surface != 0 ? seen.contact.stiffness : 0.0});
  }
  return samples;
}

/// Returns the stiffness [N/m] of two springs in series.
double series(double a, double b) { return a > 0.0 ? a * b / (a + b) : 0.0; }

/// Returns the compliance [m/N] of the touched surface. The ball counts as rigid, because MuJoCo's
/// default contact is much stiffer than the other springs.
double softness_of_surface(const Task& task) {
  return task.meant == sphere ? 0.0 : 1.0 / kTableStiffness;
}

/// Returns the depth [m] of the hand's intended position below the surface, in the coordinates of
/// the robot: minus the leader's offset.
double meant_depth(const Task& task, const ArmSample& s, double time) {
  const Vec3 place = task.meant(time).place - s.offset;
  if (task.meant != sphere) return kTable - place.z();
  // Both finger tips touch the ball at a distance of kTips from the plane of the movement.
  const double reach = std::sqrt((kBall + kTip) * (kBall + kTip) - kTips * kTips);
  return reach - length(Vec3(place + kTip * Vec3::UnitZ() - kBallAt));
}

/// Returns the expected contact force [N] of three springs in series: the hand, the arm's
/// controller and the surface. For the box, returns its weight; for the peg, nothing.
std::optional<double> intended(const Task& task, const ArmSample& s, double time,
                               double stiffness) {
  if (task.meant == lift) return kBoxMass * kGravity;
  if (task.meant == peg) return std::nullopt;
  const double softness = 1.0 / kHand.stiffness + 1.0 / stiffness + softness_of_surface(task);
  const double normal = meant_depth(task, s, time) / softness;
  const bool slides = task.meant == slide || task.meant == sphere;
  return slides ? normal * std::sqrt(1.0 + kTableFriction * kTableFriction) : normal;
}

/// Returns the largest decrease [N] of the force on the hand within 30 ms, in the samples `first`
/// to `last`.
double largest_fall(const std::vector<ArmSample>& samples, std::size_t first, std::size_t last) {
  constexpr std::size_t kWithin = 30;  // number of samples in 30 ms
  double fall = 0.0;
  for (std::size_t n = first; n <= last; ++n)
    for (std::size_t before = n - std::min(n - first, kWithin); before < n; ++before)
      fall = std::max(fall, length(samples[before].held) - length(samples[n].held));
  return fall;
}

ArmMeasured judge(const Task& task, const std::vector<ArmSample>& samples) {
  const Plant plant;
  const auto at = [&](double time) {
    return static_cast<std::size_t>(std::llround(time / plant.period));
  };
  const std::size_t first = at(task.from), last = std::min(at(task.until), samples.size() - 1);
  ArmMeasured m;
  HandEnergy energy;
  double errors = 0.0, box = 0.0;
  Vec3 robot = Vec3::Zero(), hand = Vec3::Zero();
  std::vector<double> heights;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const ArmSample& s = samples[n];
    const double force = length(s.contact);
    if (task.meant == lift && n >= last)
      m.set_down = std::max(m.set_down.value_or(0.0), force);
    else
      m.peak = std::max(m.peak, force);
    const Vec3 way = s.shown - samples[n - 1].shown;
    energy.add(samples[n - 1].held.dot(way),
               plant.leader_damping * way.squaredNorm() / plant.period, s.pushed);
    if (n < first || n >= last) continue;
    robot += s.contact;
    hand += s.held;
    errors += (s.held - s.contact).squaredNorm();
    m.flicker = std::max(m.flicker, length(Vec3(s.held - samples[n - 1].held)));
    box += s.thing.z();
    heights.push_back(s.height);
    if (const auto i = intended(task, s, static_cast<double>(n) * plant.period, plant.stiffness))
      m.intended = m.intended.value_or(0.0) + *i;
  }
  m.energy_made = energy.made();
  const auto count = static_cast<double>(heights.size());
  if (m.intended) *m.intended /= count;
  m.robot_force = length(Vec3(robot / count));
  m.hand_force = length(Vec3(hand / count));
  m.force_error = std::sqrt(errors / count);
  m.swing = highpass_rms(heights, 1.0 / plant.period);
  m.offset = length(samples[last - 1].offset);
  if (task.presses)
    m.fall = largest_fall(samples, at(*task.presses), at(*task.presses + kPressesFor));
  const double known = series(samples[last - 1].stiffness, plant.stiffness);
  if (task.meant == lift)
    m.lifted = box / count - kBoxHigh;
  else if (task.meant == peg)
    m.inserted = kBlock - (samples[last - 1].thing.z() - kPegLong);
  else
    m.displayed = known * (1.0 / plant.stiffness + softness_of_surface(task));
  return m;
}

}  // namespace

std::vector<ArmCase> arm_cases(bool quick) {
  struct Network {
    double jitter, loss;  // [s], fraction of lost datagrams
    std::uint64_t seeds;
  };
  constexpr std::uint64_t kSeeds = 8, kFew = 2;
  constexpr double kJitter = 5e-3, kLoss = 0.02;
  const std::vector<Network> networks =
      quick ? std::vector<Network>{{0.0, kLoss, kFew}}
            : std::vector<Network>{{0.0, 0.0, 1}, {0.0, kLoss, kSeeds}, {kJitter, kLoss, kSeeds}};
  const std::vector<double> trips =
      quick ? std::vector<double>{0.1} : std::vector<double>{0.0, 0.05, 0.1, 0.2};
  std::vector<ArmCase> cases;
  for (const Task& task : kTasks)
    for (const double trip : trips)
      for (const Network& network : networks)
        for (std::uint64_t seed = 1; seed <= network.seeds; ++seed)
          cases.push_back({std::string(task.name), trip, network.jitter, network.loss, seed});
  return cases;
}

std::vector<ArmRow> run_arm(const std::vector<ArmCase>& cases) {
  for (const ArmCase& c : cases) task_of(c.task);
  // MuJoCo loads models from files. An installed program has the models only as text, so write them
  // to files.
  const UnpackedFiles scenes({{"arm.xml", std::string(embedded::arm)},
                              {"table.xml", std::string(embedded::table)},
                              {"sphere.xml", std::string(embedded::sphere)},
                              {"box.xml", std::string(embedded::box)},
                              {"peg.xml", std::string(embedded::peg)}});
  std::vector<ArmRow> rows(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) {
    const Task& task = task_of(cases[i].task);
    bool stopped = false;
    const auto samples = run(cases[i], task, scenes, stopped);
    rows[i] = {cases[i], judge(task, samples)};
    rows[i].measured.stopped = stopped;
  });
  return rows;
}

}  // namespace feltwire::teleop::with_arm
