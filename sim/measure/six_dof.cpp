#include "sim/measure/six_dof.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/bounding/port_energy.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

/// Returns the configuration without the port `other` (translation or rotation). Its energy account
/// then limits only the remaining port.
AccountConfig only(AccountConfig config, PortKnowledge AccountConfig::*other) {
  config.*other = {};
  return config;
}

Pose asked_at(const Pose& device, const Probe& probe) {
  return moved(device, probe.offset, probe.rotation);
}

}  // namespace

PoseEnvironment pose_environment(const Scene& scene) {
  return [&scene, memory = BodyMemory{}](const Pose& device, const Vec3& velocity,
                                         double elapsed) mutable {
    return scene.touch(device, velocity, elapsed, memory);
  };
}

PortAccounts::PortAccounts(const AccountConfig& config, Ports ports)
    : first_(ports == Ports::one ? config : only(config, &AccountConfig::rotation)) {
  if (ports == Ports::two) torque_.emplace(only(config, &AccountConfig::translation));
}

Command PortAccounts::step(const BoundingStep& step) noexcept {
  if (!torque_) return first_.step(step);
  BoundingStep force = step, torque = step;
  force.command.torque.setZero();
  force.rotation.setZero();
  torque.command.elastic.setZero();
  torque.command.frictional.setZero();
  torque.displacement.setZero();
  Command allowed = first_.step(force);
  allowed.torque = torque_->step(torque).torque;
  return allowed;
}

void PortAccounts::set_held(const Command& held) noexcept {
  if (!torque_) return first_.set_held(held);
  first_.set_held({.elastic = held.elastic, .frictional = held.frictional});
  torque_->set_held({.torque = held.torque});
}

bool PortAccounts::in_debt() const noexcept {
  return first_.in_debt() || (torque_ && torque_->in_debt());
}

std::vector<SixDofSample> run_six_dof(const PoseEnvironment& environment,
                                      const SixDofSetup& setup) {
  const PoseEnvironment touch = environment;  // a copy with its own state
  const double period = setup.bounding.period;
  if (!(setup.duration > period) || !std::isfinite(setup.duration))
    throw std::invalid_argument("the duration must be finite and longer than one period [s]");
  if (setup.delay < 0) throw std::invalid_argument("the delay must not be negative [T]");
  if (setup.hand.spec.rotation_actuated == 0 || !setup.bounding.rotation)
    throw std::invalid_argument("six degrees of freedom need a device and a bound with rotation");
  Bounding bounding =
      setup.law == nullptr ? Bounding(setup.bounding) : Bounding(*setup.law, setup.bounding);
  std::optional<PortAccounts> account;
  if (setup.account) account.emplace(*setup.account, setup.ports);

  SimulatedDevice device(setup.hand);
  const auto count = static_cast<std::size_t>(std::floor(setup.duration / period + 0.5)) + 1;
  std::vector<SixDofSample> samples;
  samples.reserve(count);
  // Commands in transit: the command of a sample arrives `delay` samples later.
  std::vector<Command> under_way(static_cast<std::size_t>(setup.delay) + 1);
  Pose before = device.read(Nanoseconds{0}).pose;
  Vec3 last_offset = Vec3::Zero();
  Command held;
  for (std::size_t n = 0; n < count; ++n) {
    SixDofSample s;
    s.time = static_cast<double>(n) * period;
    const Pose measured = device.read(Nanoseconds(std::llround(s.time * 1e9))).pose;
    s.pose = {device.true_position(), device.true_orientation()};
    s.energy = device.true_energy();
    s.displacement = measured.position - before.position;
    s.rotation = rotation_between(before.orientation, measured.orientation);
    s.held = held;
    before = measured;

    // The bounding method chooses the pose at which the environment computes the force.
    const Probe probe = bounding.probe(s.displacement, s.rotation);
    const Vec3 velocity = (s.displacement + probe.offset - last_offset) / period;
    last_offset = probe.offset;
    under_way[n % under_way.size()] =
        actuated(device.spec(), touch(asked_at(measured, probe), velocity, n > 0 ? period : 0.0));
    s.commanded = under_way[(n + 1) % under_way.size()];
    BoundingStep step{.displacement = s.displacement,
                      .rotation = s.rotation,
                      .hold_time = period,
                      .command = s.commanded,
                      .local = setup.delay == 0};
    step.command = bounding.step(step).rendered;
    if (account) {
      step.command = account->step(step);
      s.in_debt = account->in_debt();
    }
    s.rendered = held = device.write(step.command);
    bounding.set_held(held);
    if (account) account->set_held(held);
    samples.push_back(s);
  }
  return samples;
}

SixDofEnergy energy_made(const DeviceSpec& spec, const std::vector<SixDofSample>& samples,
                         double period) {
  const DryFriction friction{spec.least_friction, spec.position_resolution};
  PortEnergy both(spec.damping, spec.rotational_damping, period, friction);
  PortEnergy force = both, torque = both;
  double real = 0.0, most = 0.0;  // [J] delivered minus dissipated energy: now, and its maximum
  Pose before = samples.front().pose;
  for (const SixDofSample& s : samples) {
    both.step(s.held, s.displacement, s.rotation, period);
    force.step(s.held, s.displacement, Vec3::Zero(), period);
    torque.step(s.held, Vec3::Zero(), s.rotation, period);
    const Vec3 moved = s.pose.position - before.position;
    const Vec3 turned = rotation_between(before.orientation, s.pose.orientation);
    real += s.held.force().dot(moved) + s.held.torque.dot(turned) -
            (spec.damping.quadratic(moved) + spec.rotational_damping.quadratic(turned)) / period -
            spec.coulomb_friction * moved.lpNorm<1>() - spec.rotation.friction * turned.lpNorm<1>();
    before = s.pose;
    most = std::max(most, real);
  }
  return {.measured = -both.least_margin(),
          .real = most,
          .force = -force.least_margin(),
          .torque = -torque.least_margin()};
}

}  // namespace feltwire
