#pragma once
// Shared by the core tests: seeded random values over many decades, and malicious hands.

#include <cmath>
#include <random>

#include "core/bounding/bounding.hpp"
#include "core/bounding/port_energy.hpp"

namespace feltwire::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double lo, double hi) { return lo + (hi - lo) * unit(); }
  bool chance(double probability) { return unit() < probability; }
  /// Magnitude spread evenly over the decades 10^lo .. 10^hi, either sign.
  double decades(double lo, double hi) {
    return (chance(0.5) ? 1.0 : -1.0) * std::pow(10.0, uniform(lo, hi));
  }
  Vec3 direction() {
    Vec3 v;
    do {
      for (double& x : v) x = uniform(-1.0, 1.0);
    } while (v.norm() < 0.1 || v.norm() > 1.0);
    return v.normalized();
  }
  Vec3 vector(double lo, double hi) { return decades(lo, hi) * direction(); }

 private:
  // Not std::uniform_real_distribution: its bits differ between standard libraries.
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

inline constexpr double kModePeriod = 1e-3;  // [s]

/// A configuration of a mode with damping in translation and rotation; torque is rendered.
inline BoundingConfig config(std::string_view mode, double damping = 0.5) {
  BoundingConfig c;
  c.mode = mode;
  c.period = kModePeriod;
  c.damping = damping;
  c.rotational_damping = 1e-3;
  c.rotation = true;
  return c;
}

/// An unphysical command: every channel over six decades, sometimes without contact or without a
/// part, with friction anywhere between orthogonal to the normal and along it.
inline Command random_command(Random& random) {
  Command c;
  if (random.chance(0.1)) return c;
  if (random.chance(0.8)) c.elastic = random.vector(-3.0, 3.0);
  if (random.chance(0.8)) c.frictional = random.vector(-3.0, 3.0);
  if (random.chance(0.8)) c.torque = random.vector(-5.0, 1.0);
  return c;
}

/// The displacement that takes most energy from a port while `f` is held for `time`: it minimises
/// F.dx + (b/time) |dx|^2.
inline Vec3 greediest(const Vec3& f, double time, double damping) {
  return f * (time / (2.0 * damping));
}

/// The angle between two vectors [rad], exact for small angles too.
inline double angle(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace feltwire::test
