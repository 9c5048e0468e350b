#pragma once
// The two ends of feltwire's own law in three dimensions, made of the parts that sessions use.

#include <cstdint>
#include <optional>

#include "core/bounding/account.hpp"
#include "core/bounding/midpoint.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/surface_offset.hpp"
#include "core/teleoperation/target_limiter.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// The leader's message in each sample.
struct LeaderState {
  std::uint64_t index = 0;
  Vec3 wanted = Vec3::Zero();  // [m] wanted place of the robot: the hand less the leader's offset
  std::uint32_t known = 0;     // surface that the leader knows
  double hand_work = 0.0;      // [J] total that the hand paid
  double gripper = 0.0;        // [m] wanted opening
};

/// The follower's message in each sample.
struct FollowerState {
  std::uint64_t index = 0;
  double time = 0.0;  // [s]; the clocks of both ends agree
  RemoteContact contact;
  OtherSurfaces others;
  EnergyCounters energy;
};

/// The hand's end: renders the newest contact as a local model, half a sample ahead, behind the
/// account of its port, which gets the environment's energy as credit.
class RemoteLeader {
 public:
  explicit RemoteLeader(const Plant& plant);

  /// Takes any received state, in any order.
  void take(const EnergyCounters& seen) noexcept { remote_.take(seen); }

  /// `contact` is the newest known one, `age` [s] old. Returns the force on the hand until the next
  /// sample [N].
  Vec3 step(const Vec3& hand, const Vec3& velocity, const RemoteContact& contact,
            const OtherSurfaces& others, double age);

  const Vec3& offset() const noexcept { return surface_offset_.offset(); }
  std::uint32_t known_surface() const noexcept { return surface_offset_.known_surface(); }
  double hand_work() const noexcept { return hand_work_; }

 private:
  void show(const RemoteContact& contact, const OtherSurfaces& others, const Vec3& hand);

  Plant plant_;
  SurfaceOffset surface_offset_;
  LocalContact local_;
  Midpoint<double> midpoint_;
  PortAccount account_;
  RemoteEnergy remote_;
  Vec3 held_ = Vec3::Zero();         // [N] on the hand
  std::optional<Vec3> hand_before_;  // [m]
  double hand_work_ = 0.0;           // [J]
};

/// The robot's end: estimates the surface that the tool touches, and limits the target.
class RemoteFollower {
 public:
  explicit RemoteFollower(const Plant& plant);

  /// Call it for every sample, before target(). `force` [N]: of the environment on the tool.
  /// `prior`: the surface there, as known before its touch.
  const RemoteContact& step(const Vec3& tip, const Vec3& velocity, const Vec3& force,
                            const SurfacePrior& prior = {});
  /// [m] The target for the newest state of the leader.
  const Vec3& target(const LeaderState& newest);

  const RemoteContact& contact() const noexcept { return estimate_.contact(); }
  const OtherSurfaces& others() const noexcept { return estimate_.others(); }
  const EnergyCounters& energy() const noexcept { return counted_.counters(); }

 private:
  Plant plant_;
  ContactEnergy counted_;
  ContactEstimator estimate_;
  TargetLimiter limiter_;
  Vec3 tip_ = Vec3::Zero();         // [m]
  Vec3 force_ = Vec3::Zero();       // [N]
  std::optional<Vec3> tip_before_;  // [m]
};

/// Returns `now` less `before`, and sets `before` to `now`; zero the first time.
Vec3 moved(std::optional<Vec3>& before, const Vec3& now);

}  // namespace feltwire::teleop
