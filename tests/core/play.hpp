#pragma once
// Plays a script against a bound, and sums energies for the tests meanwhile.

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/core/in_arithmetic.hpp"
#include "tests/core/script.hpp"

namespace feltwire::test {

/// The real device; the bound may have been told otherwise.
struct Port {
  Damping damping = 0.5;              // [N s/m]
  Damping rotational_damping = 1e-3;  // [N m s/rad]
};

/// A sample of a script while it is played, with the values that the bound's arithmetic sees.
template <class Real>
struct Played {
  const Tick* tick = nullptr;
  Command before;  // held while the device moved
  Vec3 displacement, rotation;
  double hold_time = 0.0;  // [s]
  BasicBoundingStep<Real> told;
  BasicBounded<Real> out;
  Command held;  // from this sample on
  bool new_law = false;
};

/// dx = B^-1 f h / 2: minimises dx' B dx / h - f.dx.
inline Vec3 greediest(const Vec3& f, double time, const Damping& damping) {
  return 0.5 * time * damping.matrix().inverse() * f;
}

/// The answer of the wall z < 0: an elastic force, and friction against the last movement.
inline Command wall(const Script& script, const Vec3& position, const Vec3& displacement) {
  Command c;
  c.elastic.z() = script.stiffness * std::max(0.0, -position.z());
  const Vec3 along(displacement.x(), displacement.y(), 0.0);
  c.frictional = -script.friction * c.elastic.z() * direction(along);
  return c;
}

/// Calls judge(Played, BasicBounding) after every tick. As in server/scene/session.cpp, a new law
/// starts with no held force and without the movement that led to its first sample: what the old
/// law stored pays for that.
template <class Real = double, class Judge>
void play(const Script& script, const std::vector<BoundingConfig>& laws, const Port& port,
          Judge judge) {
  constexpr double kFarthest = 0.1;  // [m], [rad] a tick: no hand is faster
  const double period = laws[0].period;
  BasicBounding<Real> bounding = bounding_in<Real>(laws[0]);
  std::vector<Command> sent;
  Vec3 position = Vec3::Zero();
  Played<Real> p;
  for (std::size_t n = 0; n < script.ticks.size(); ++n) {
    const Tick& t = script.ticks[n];
    p.tick = &t;
    p.before = p.held;
    p.hold_time = t.hold * period;

    const double time = std::max(p.hold_time, period);
    const Vec3 normal = direction(p.held.elastic);
    Vec3 take = t.share * greediest(p.held.force(), time, port.damping);
    Vec3 turn = t.share * greediest(p.held.torque, time, port.rotational_damping);
    if (t.hand == Hand::takes_along) take = along(take, normal);
    if (t.hand == Hand::takes_across) take -= along(take, normal);
    if (t.hand == Hand::wanders) take = turn = Vec3::Zero();
    if (t.hand == Hand::trembles) {
      take = Vec3(0, 0, (n % 2 ? 1.0 : -1.0) * t.share * script.tremble);
      turn = 10.0 * take;
    }
    take += t.displacement;
    turn += t.rotation;
    for (Vec3* v : {&take, &turn})
      if (v->norm() > kFarthest) *v *= kFarthest / v->norm();
    p.told.displacement = take.cast<Real>();
    p.told.rotation = turn.cast<Real>();
    p.told.hold_time = static_cast<Real>(p.hold_time);
    p.displacement = p.told.displacement.template cast<double>();
    p.rotation = p.told.rotation.template cast<double>();
    position += p.displacement;

    sent.push_back(t.wall ? wall(script, position, p.displacement) : t.command);
    const Command& used = sent[n - std::min(n, static_cast<std::size_t>(t.age))];
    p.told.command = used.cast<Real>();
    if (t.lost) p.told.displacement.x() = std::numeric_limits<Real>::quiet_NaN();

    p.new_law = t.law >= 0;
    if (p.new_law) {
      bounding = bounding_in<Real>(laws[static_cast<std::size_t>(t.law) % laws.size()]);
      p.told.displacement.setZero();
      p.told.rotation.setZero();
    }
    p.out = bounding.step(p.told);

    BasicCommand<Real> held = static_cast<Real>(t.kept) * p.out.rendered;
    if (!t.bent.isZero(0)) {
      const Real bent_length = held.force().norm();
      held.elastic = bent_length * t.bent.cast<Real>();
      held.frictional.setZero();
    }
    if (t.skipped) held = p.before.template cast<Real>();
    if (!(held == p.out.rendered)) bounding.set_held(held);
    p.held = held.template cast<double>();
    judge(std::as_const(p), std::as_const(bounding));
  }
}

/// A sum of energies and its possible rounding error. The sum of n terms, each wrong by some ulps,
/// is wrong by at most about n ulps of the sum of their magnitudes.
struct Sum {
  double value = 0.0, magnitudes = 0.0;
  int terms = 0;
  void add(double term) {
    value += term;
    magnitudes += std::abs(term);
    ++terms;
  }
  void add(const Vec3& f, const Vec3& dx) {
    for (int i = 0; i < 3; ++i) add(f[i] * dx[i]);
  }
  template <class Real>
  double rounding(double condition = 1.0) const {
    return 8.0 * (terms + 8) * condition * std::numeric_limits<Real>::epsilon() * magnitudes;
  }
};

/// burned - delivered of a port, translation and rotation.
struct Margin {
  Port port;
  double period = kModePeriod;
  Sum translation{}, rotation{};
  template <class Real>
  void account(const Played<Real>& p) {
    const double time = std::max(p.hold_time, period);
    translation.add(port.damping.quadratic(p.displacement) / time);
    translation.add(-p.before.force(), p.displacement);
    rotation.add(port.rotational_damping.quadratic(p.rotation) / time);
    rotation.add(-p.before.torque, p.rotation);
  }
  /// Whether the hand took no more than was burned, within the rounding of `Real`.
  template <class Real>
  bool kept(double condition = 1.0) const {
    return translation.value >= -translation.rounding<Real>(condition) &&
           rotation.value >= -rotation.rounding<Real>(condition);
  }
};

}  // namespace feltwire::test
