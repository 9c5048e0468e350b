#include "sim/studies/teleop/space_bench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/clamp_length.hpp"
#include "core/base/numeric.hpp"
#include "sim/studies/teleop/bench_energy.hpp"
#include "sim/studies/teleop/one_way_link.hpp"
#include "sim/studies/teleop/sensors.hpp"

namespace feltwire::teleop::in_space {
namespace {

struct Mass {
  Vec3 position, velocity = Vec3::Zero();

  /// Moves the mass for `time` [s]. The damping is integrated implicitly, so it cannot reverse the
  /// velocity.
  void step(const Vec3& force, double damping, double mass, double time) {
    velocity = (velocity + time / mass * force) / (1.0 + time * damping / mass);
    position += time * velocity;
  }
};

Vec3 each_rounded(const Vec3& v, double quantum) {
  return {rounded(v.x(), quantum), rounded(v.y(), quantum), rounded(v.z(), quantum)};
}

Vec3 noise3(std::uint64_t seed, std::uint64_t n) {
  return {noise(seed, 3 * n), noise(seed, 3 * n + 1), noise(seed, 3 * n + 2)};
}

/// Computes the contact force of a shape on the robot.
class Touch {
 public:
  Touch(const Shape& shape, const Vec3& start) : shape_(shape), proxy_(shape, start) {}

  Vec3 force(const Mass& robot) {
    proxy_.follow(robot.position);
    const Vec3 spring = proxy_.force(robot.position, shape_.stiffness);
    const Vec3 normal = direction(spring);
    const double along = length(spring) - shape_.damping * robot.velocity.dot(normal);
    return spring.isZero(0.0) ? spring : Vec3(std::max(0.0, along) * normal);
  }

 private:
  Shape shape_;
  SurfaceProxy proxy_;
};

}  // namespace

std::vector<SpaceSample> run_space_bench(SpatialLaw& law, const SpaceSetup& setup) {
  const Plant& plant = setup.plant;
  const double period = plant.period, part = period / kParts;
  OneWayLink<SpatialDatagram> forth(setup.link, link_key(setup.seed, 0, LinkDirection::up));
  OneWayLink<SpatialDatagram> back(setup.link, link_key(setup.seed, 0, LinkDirection::down));
  const Vec3 start = setup.intention(0.0);
  Touch touch(setup.around, start);
  Mass hand{start}, robot{start};
  const double hand_mass = setup.hand.mass + plant.leader_mass;
  const double smooth = 1.0 - std::exp(-2.0 * std::numbers::pi * kVelocityCutoff * period);
  Vec3 shown = each_rounded(start, plant.leader_quantum), velocity = Vec3::Zero();
  Vec3 held = Vec3::Zero(), contact = Vec3::Zero();
  ContactPush push;
  std::vector<SpaceSample> samples;
  const auto count = static_cast<std::uint64_t>(std::llround(setup.duration / period));
  samples.reserve(count);
  for (std::uint64_t n = 0; n < count; ++n) {
    const double now = static_cast<double>(n) * period;
    const Vec3 before = shown;
    shown = each_rounded(hand.position, plant.leader_quantum);
    velocity += smooth * ((shown - before) / period - velocity);
    samples.push_back(
        {hand.position, shown, held, robot.position, law.offset(), contact, push.pushed});

    SpatialDatagram sent{.index = n, .time = now};
    held =
        clamp_length(law.lead({now, shown, velocity}, back.receive(now), sent), plant.leader_force);
    forth.send(sent, now);
    const Vec3 sensed = contact + setup.wrench_noise * noise3(setup.seed + 1, n);
    SpatialDatagram answer{.index = n, .time = now};
    const SpatialFollowerForce servo =
        law.follow({now, robot.position, robot.velocity, sensed}, forth.receive(now), answer);
    back.send(answer, now);

    for (int i = 0; i < kParts; ++i) {
      const double time = now + (i + 0.5) * part;
      const Vec3 meant = setup.intention(time);
      const Vec3 pace = (setup.intention(time + part) - meant) / part;
      const Vec3 grip =
          setup.hand.stiffness * (meant - hand.position) + setup.hand.damping * pace - held;
      hand.step(grip, setup.hand.damping + plant.leader_damping, hand_mass, part);

      contact = touch.force(robot);
      const Vec3 drive = servo.force + servo.damping * servo.reference + contact;
      robot.step(drive, servo.damping + plant.follower_damping, plant.follower_mass, part);
      push.add(!contact.isZero(0.0), contact.dot(part * robot.velocity));
    }
  }
  return samples;
}

}  // namespace feltwire::teleop::in_space
