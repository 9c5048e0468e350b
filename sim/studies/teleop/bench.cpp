#include "sim/studies/teleop/bench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/studies/teleop/bench_energy.hpp"
#include "sim/studies/teleop/one_way_link.hpp"
#include "sim/studies/teleop/sensors.hpp"

namespace feltwire::teleop {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

struct Mass {
  double position = 0.0, velocity = 0.0;
};

class World {
 public:
  explicit World(const Surroundings& around) : around_(around) {}

  /// Returns the position [m] of the surface at `time` [s].
  double surface(double time) const {
    if (around_.kind == Surroundings::Kind::weight) return weight_.position;
    if (time < around_.moves_from) return 0.0;
    return around_.swing * std::sin(kTwoPi * around_.frequency * (time - around_.moves_from));
  }

  /// Returns the contact force [N] on the robot. Also moves the weight, if there is one, for `step`
  /// [s].
  double touch(const Mass& robot, double time, double step) {
    if (around_.kind == Surroundings::Kind::nothing || time >= around_.vanishes) return 0.0;
    const bool weight = around_.kind == Surroundings::Kind::weight;
    const double speed = weight ? weight_.velocity : surface_speed(time);
    const double depth = robot.position - surface(time);
    double force = 0.0;
    if (depth > 0.0)
      force = std::max(0.0, around_.stiffness * depth + around_.damping * (robot.velocity - speed));
    if (weight) {
      // The ground is at 0 and stops the weight.
      weight_.velocity += step * (force / around_.mass - kGravity);
      weight_.position += step * weight_.velocity;
      if (weight_.position < 0.0) weight_ = {};
    }
    return force;
  }

 private:
  double surface_speed(double time) const {
    if (time < around_.moves_from) return 0.0;
    const double rate = kTwoPi * around_.frequency;
    return around_.swing * rate * std::cos(rate * (time - around_.moves_from));
  }
  Surroundings around_;
  Mass weight_;
};

}  // namespace

std::vector<BenchSample> run_bench(TeleoperationLaw& law, const BenchSetup& setup) {
  const Plant& plant = setup.plant;
  const double period = plant.period, part = period / kParts;
  OneWayLink<Datagram> forth(setup.link, link_key(setup.seed, 0, LinkDirection::up));
  OneWayLink<Datagram> back(setup.link, link_key(setup.seed, 0, LinkDirection::down));
  World world(setup.around);
  const double start = setup.intention(0.0);
  Mass hand{start}, robot{start};
  const double hand_mass = setup.hand.mass + plant.leader_mass;
  const double smooth = 1.0 - std::exp(-kTwoPi * kVelocityCutoff * period);
  double shown = rounded(start, plant.leader_quantum), velocity = 0.0;
  double held = 0.0, contact = 0.0;
  ContactPush push;
  std::vector<BenchSample> samples;
  const auto count = static_cast<std::uint64_t>(std::llround(setup.duration / period));
  samples.reserve(count);
  for (std::uint64_t n = 0; n < count; ++n) {
    const double now = static_cast<double>(n) * period;
    const bool cut = now >= setup.cut_from && now < setup.cut_until;
    const double before = shown;
    shown = rounded(hand.position, plant.leader_quantum);
    velocity += smooth * ((shown - before) / period - velocity);
    samples.push_back({hand.position, shown, held, robot.position, law.offset(), world.surface(now),
                       contact, push.pushed});

    Datagram sent{.index = n, .time = now};
    held = std::clamp(law.lead({now, shown, velocity}, back.receive(now), sent),
                      -plant.leader_force, plant.leader_force);
    forth.send(sent, now, cut);
    const double sensed = -contact + setup.wrench_noise * noise(setup.seed + 1, n);
    Datagram answer{.index = n, .time = now};
    const FollowerForce servo =
        law.follow({now, robot.position, robot.velocity, sensed}, forth.receive(now), answer);
    back.send(answer, now, cut);

    for (int i = 0; i < kParts; ++i) {
      const double time = now + (i + 0.5) * part;
      const double meant = setup.intention(time);
      const double pace = (setup.intention(time + part) - meant) / part;
      const double grip =
          setup.hand.stiffness * (meant - hand.position) + setup.hand.damping * pace - held;
      // The damping is integrated implicitly, so it cannot reverse the velocity.
      hand.velocity = (hand.velocity + part * grip / hand_mass) /
                      (1.0 + part * (setup.hand.damping + plant.leader_damping) / hand_mass);
      hand.position += part * hand.velocity;

      contact = world.touch(robot, time, part);
      const double drive = servo.force + servo.damping * servo.reference - contact;
      robot.velocity =
          (robot.velocity + part * drive / plant.follower_mass) /
          (1.0 + part * (servo.damping + plant.follower_damping) / plant.follower_mass);
      robot.position += part * robot.velocity;
      push.add(contact > 0.0, -(contact * part * robot.velocity));
    }
  }
  return samples;
}

}  // namespace feltwire::teleop
