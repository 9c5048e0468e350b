#pragma once
// A simulated robot that is a mass with an impedance controller, in a scene of its own.

#include <atomic>
#include <cstdint>
#include <memory>
#include <random>

#include "core/scene/scene.hpp"
#include "core/teleoperation/follower.hpp"

namespace feltwire {

struct PointRobotOptions {
  double mass = 2.0;           // [kg]
  double stiffness = 1000.0;   // K [N/m] of its controller
  double damping = 60.0;       // [N s/m] of its controller, against the target's own speed
  double own_damping = 2.0;    // [N s/m] of its body
  double wrench_noise = 0.03;  // [N] largest error of its sensor on each axis
  double servo_period = 1e-3;  // [s]
  std::uint64_t seed = 1;      // of the noise
};

/// A mass at a point, which a spring and a damper pull to the target and the scene pushes away:
///   m x'' = K (x_t - x) + B (x_t' - x') - b x' + F,     x_t' low-passed at 20 Hz
/// Semi-implicit Euler in steps of at most 50 us. It turns to the commanded orientation at once. It
/// has a scene of its own, which no server needs to know. Deterministic: the same targets and
/// reading times give the same bits.
class PointRobot final : public Follower {
 public:
  /// It begins at rest at `position` [m]. Throws std::invalid_argument if a number is not usable.
  PointRobot(std::shared_ptr<const Scene> scene, const Vec3& position,
             const PointRobotOptions& options = {});

  const FollowerSpec& spec() const override { return spec_; }
  FollowerReading read(Nanoseconds now) noexcept override;
  FollowerTarget write(const FollowerTarget& target) noexcept override;
  void hold() noexcept override { held_.store(true); }

  const Vec3& position() const { return position_; }  // [m]
  const Vec3& force() const { return force_; }        // [N] of the scene on it, without noise

  /// A protective stop, as a person would make it, which keeps the target at its place, and its
  /// end.
  void stop(bool stopped) noexcept { stopped_ = stopped; }

 private:
  void integrate(double time) noexcept;

  std::shared_ptr<const Scene> scene_;
  PointRobotOptions options_;
  FollowerSpec spec_;
  TouchMemory memory_;
  std::mt19937_64 random_;
  Vec3 position_, velocity_ = Vec3::Zero(), force_ = Vec3::Zero();
  FollowerTarget target_;
  Vec3 target_before_;                   // [m] at the reading before
  Vec3 target_velocity_ = Vec3::Zero();  // [m/s] low-passed
  bool started_ = false, stopped_ = false;
  std::atomic<bool> held_{false};
  Nanoseconds last_{0};
};

}  // namespace feltwire
