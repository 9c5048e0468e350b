#include "sim/studies/bound/passivity_claims.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// long double can represent the squares of the smallest doubles.
using Vector = Eigen::Matrix<long double, 3, 1>;
long double length(const Vec3& v) { return v.cast<long double>().norm(); }

bool by_axis(Promise promise) {
  return promise == Promise::port_by_axis || promise == Promise::own_sum_by_axis;
}
bool own_sum(Promise promise) {
  return promise == Promise::own_sum || promise == Promise::own_sum_by_axis;
}

}  // namespace

PromiseLedger::PromiseLedger(const Setup& setup) : setup_(setup) {
  const auto open = [&](Port& port, const Damping& damping) {
    // A per-axis law uses only the damping that each axis has by itself.
    port.damping = setup_.promise == Promise::port_by_axis ? Damping(damping.per_axis()) : damping;
    const double least = port.damping.least();
    if (!(least > 0.0)) return;
    port.inverse = port.damping.matrix().inverse();
    if (port.damping.isotropic()) return;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(port.damping.matrix(), Eigen::EigenvaluesOnly);
    port.condition = eigen.eigenvalues().maxCoeff() / least;
  };
  open(translation_, setup_.damping);
  open(rotation_, setup_.rotational_damping);
}

void PromiseLedger::moved(const Command& held, const Vec3& displacement, const Vec3& rotation,
                          double hold_time) {
  const Vec3 force = held.force();
  if (setup_.promise == Promise::none || own_sum(setup_.promise)) return;
  exchange(translation_, force, displacement, hold_time);
  exchange(rotation_, held.torque, rotation, hold_time);
}

void PromiseLedger::exchange(Port& port, const Vec3& force, const Vec3& displacement,
                             double hold_time) {
  const double hold = std::max(hold_time, setup_.period);
  long double all = 0.0L;
  if (by_axis(setup_.promise)) {
    for (int i = 0; i < 3; ++i) {
      const long double moved = displacement[i];
      const long double burned = port.damping.matrix()(i, i) * moved * moved / hold;
      port.balance[static_cast<std::size_t>(i)] += burned - force[i] * moved;
      all += burned;
    }
  } else {
    const Vector dx = displacement.cast<long double>();
    const long double burned = dx.dot(port.damping.matrix().cast<long double>() * dx) / hold;
    port.balance[0] += burned - force.cast<long double>().dot(dx);
    all += burned;
  }
  all += length(force) * length(displacement);
  port.exchanged += all;
  port.through += all;
}

void PromiseLedger::tool_moved(const Tool& translation, const Tool& rotation) {
  const auto book = [](Port& port, const Tool& tool) {
    port.balance[0] += tool.work;
    port.exchanged += std::abs(tool.work);
    port.through += std::abs(tool.work);
    port.tool_stored = tool.stored;
  };
  book(translation_, translation);
  book(rotation_, rotation);
}

void PromiseLedger::rendered(const Command& rendered, const Command& commanded,
                             const Vec3& displacement, const Vec3& rotation) {
  if (setup_.promise == Promise::none) return;
  if (setup_.one_balance) {
    judge_together(rendered, displacement, rotation);
    return;
  }
  const Vec3 force = rendered.force();
  if (!own_sum(setup_.promise)) {
    judge(translation_, force, displacement);
    judge(rotation_, rendered.torque, rotation);
    return;
  }
  const auto observe = [&](Port& port, const Vec3& f, const Vec3& wanted, const Vec3& dx) {
    for (int i = 0; i < 3; ++i)
      port.balance[by_axis(setup_.promise) ? static_cast<std::size_t>(i) : 0] -=
          static_cast<long double>(f[i]) * dx[i];
    // A passivity controller may cancel nearly the whole command. So its rounding error depends on
    // the command too.
    const long double flow = (length(f) + length(wanted)) * length(dx);
    port.exchanged += flow;
    port.through += flow;
  };
  // A law with a single energy observer adds up the work of force and torque.
  Port& second = setup_.promise == Promise::own_sum ? translation_ : rotation_;
  observe(translation_, force, commanded.force(), displacement);
  observe(second, rendered.torque, commanded.torque, rotation);
  judge(translation_, force, displacement);
  if (&second == &rotation_) judge(rotation_, rendered.torque, rotation);
}

long double PromiseLedger::at_stake(const Port& port, const Vec3& held) const {
  if (held.isZero(0.0)) return 0.0L;
  if (!(port.inverse(0, 0) > 0.0)) return std::numeric_limits<long double>::infinity();
  const Vector f = held.cast<long double>();
  return f.dot(port.inverse.cast<long double>() * f) * (0.25 * setup_.period);
}

long double PromiseLedger::stored(Port& port, const Vec3& force, const Vec3& displacement) const {
  const long double all_at_stake = at_stake(port, force);
  // Without damping, any force is at stake without a limit. This must not become an allowance.
  const bool limited = !own_sum(setup_.promise) && std::isfinite(all_at_stake);
  long double kept = limited ? all_at_stake : 0.0L;
  for (const long double balance : port.balance)
    kept = std::max(kept, setup_.keeps_all ? std::abs(balance) : -balance);
  if (setup_.promise == Promise::coupling) kept = port.tool_stored;
  port.through += kept;
  // Allow for the energy error if the force, the movement and a stored energy are wrong by the
  // smallest representable number.
  const double least = setup_.arithmetic.least;
  const double per_force = 0.5 * setup_.period * port.inverse.diagonal().maxCoeff();
  const long double f = length(force), dx = length(displacement);
  port.tiny += (per_force * (f + least) + dx + f + (setup_.keeps_all ? 1.0L : 0.0L)) * least;
  return all_at_stake;
}

void PromiseLedger::judge_together(const Command& rendered, const Vec3& displacement,
                                   const Vec3& rotation) {
  const long double at_stake = stored(translation_, rendered.force(), displacement) +
                               stored(rotation_, rendered.torque, rotation);
  Port both;
  both.condition = std::max(translation_.condition, rotation_.condition);
  for (const Port* port : {&translation_, &rotation_}) {
    both.balance[0] += port->balance[0];
    both.exchanged += port->exchanged;
    both.through += port->through;
    both.tiny += port->tiny;
  }
  if (at_stake > 0.0L) judge(both, at_stake - both.balance[0]);
}

void PromiseLedger::judge(Port& port, const Vec3& force, const Vec3& displacement) {
  const long double all_at_stake = stored(port, force, displacement);
  switch (setup_.promise) {
    case Promise::port:
      // A rendered force needs a sufficient balance. Without a force, a negative balance is
      // allowed.
      if (all_at_stake > 0.0L) judge(port, all_at_stake - port.balance[0]);
      break;
    case Promise::port_by_axis:
      for (int i = 0; i < 3; ++i) {
        const long double own = at_stake(port, force[i] * Vec3::Unit(i));
        if (own > 0.0L) judge(port, own - port.balance[static_cast<std::size_t>(i)]);
      }
      break;
    case Promise::coupling:
    case Promise::own_sum:
    case Promise::own_sum_by_axis:
      for (const long double balance : port.balance) judge(port, -balance);
      break;
    case Promise::none:
      break;
  }
}

void PromiseLedger::judge(const Port& port, long double missing) {
  missing -= kEnergyRounding * port.tiny;
  if (!(missing > 0.0L)) return;
  const long double allowed =
      kEnergyRounding * setup_.arithmetic.epsilon * port.condition * port.through;
  broken_ = broken_ || missing > allowed;
  const auto share = [&](long double energy) {
    return port.exchanged > 0.0L ? static_cast<double>(energy / port.exchanged) : kUnlimited;
  };
  if (share(missing) <= error_) return;
  error_ = share(missing);
  rounding_ = share(allowed);
}

}  // namespace feltwire
