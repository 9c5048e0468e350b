#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "core/bounding/bounding.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/two_port_bound.hpp"
#include "sim/teleoperation_laws/impedance_follower.hpp"

namespace feltwire::teleop {

/// A bound at the hand's port, of core/bounding. Forces as F, which resists the hand.
class BoundedHand {
 public:
  /// `method`: a bounding method of the registry, "none" for no bound.
  BoundedHand(const Plant& plant, std::string_view method);
  /// The hand is at `hand` [m] now. Returns the force until the next sample [N].
  Vec3 step(const Vec3& hand, const Vec3& wanted);

 private:
  double period_;
  Bounding bound_;
  std::optional<Vec3> before_;  // [m]
};

/// The two-port law (T) at the hand's port, and the follower's counter that it needs.
class TwoPortHand {
 public:
  explicit TwoPortHand(const Plant& plant);
  void take(const EnergyCounters& seen) { remote_.take(seen); }
  /// `apart`: the newest message of the robot says that it touches nothing.
  Vec3 step(const Vec3& hand, const Vec3& wanted, bool apart);

 private:
  double period_;
  TwoPortBound bound_;
  RemoteEnergy remote_;
  std::optional<Vec3> before_;  // [m]
  Vec3 held_ = Vec3::Zero();    // [N] on the hand
};

/// P-F: the robot follows the leader's position; the hand gets the force that the robot measures.
/// Without a bound it is stable only if the robot is light
///   F = F_e(t - d)
/// Source: Lawrence, "Stability and transparency in bilateral teleoperation", IEEE Trans. Robotics
/// and Automation 9(5), 1993: channels C1 and C2.
/// With a bound at the leader, one of core/bounding: the paper's per_axis (the energy bounding
/// algorithm) or contact_frame; the hand's port is passive for any delay.
/// Source of the first for teleoperation: Seo, Kim, Kim, Ryu, "Stable bilateral teleoperation using
/// the energy-bounding algorithm: basic idea and feasibility tests", J. Mechanical Science and
/// Technology 25(11), 2011. Decided here: it bounds the hand's port alone. At the robot's port,
/// told of the robot's own damping, it would let no force rise while the robot rests.
class PositionForce final : public TeleoperationLaw {
 public:
  PositionForce(const Plant& plant, std::string_view method)
      : bound_(plant, method), follower_(plant) {}
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override {
    return follower_.step(sample, arrived, out);
  }

 private:
  BoundedHand bound_;
  ImpedanceFollower follower_;
  Newest newest_;
};

/// P-F behind the two-port law (T) (core/teleoperation/two_port_bound.hpp): as with contact_frame,
/// and a remote that moves may push the hand.
class PositionForceTwoPort final : public TeleoperationLaw {
 public:
  explicit PositionForceTwoPort(const Plant& plant)
      : period_(plant.period), bound_(plant), counted_(plant.wrench_noise), follower_(plant) {}
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override;

 private:
  double period_;
  TwoPortHand bound_;
  ContactEnergy counted_;
  ImpedanceFollower follower_;
  Newest newest_;
  std::optional<Vec3> follower_before_;  // [m]
};

/// PositionForce in three degrees of freedom. The energy bounding algorithm of the paper for
/// several is per_axis_projected: each axis is bounded, and the force projected on the wanted
/// direction.
/// Source: Kim, Kim, Seo, Ryu, "Directionally transparent energy bounding approach for multiple
/// degree-of-freedom haptic interaction".
class SpatialPositionForce final : public SpatialLaw {
 public:
  SpatialPositionForce(const Plant& plant, std::string_view method)
      : bound_(plant, method), follower_(plant) {}
  Vec3 lead(const SpatialLeaderSample& sample, std::span<const SpatialDatagram> arrived,
            SpatialDatagram& out) override;
  SpatialFollowerForce follow(const SpatialFollowerSample& sample,
                              std::span<const SpatialDatagram> arrived,
                              SpatialDatagram& out) override {
    return follower_.step(sample, arrived, out);
  }

 private:
  BoundedHand bound_;
  SpatialImpedance follower_;
  NewestOf<SpatialDatagram> newest_;
};

/// PositionForceTwoPort in three degrees of freedom.
class SpatialTwoPortForce final : public SpatialLaw {
 public:
  explicit SpatialTwoPortForce(const Plant& plant)
      : period_(plant.period), bound_(plant), counted_(plant.wrench_noise), follower_(plant) {}
  Vec3 lead(const SpatialLeaderSample& sample, std::span<const SpatialDatagram> arrived,
            SpatialDatagram& out) override;
  SpatialFollowerForce follow(const SpatialFollowerSample& sample,
                              std::span<const SpatialDatagram> arrived,
                              SpatialDatagram& out) override;

 private:
  double period_;
  TwoPortHand bound_;
  ContactEnergy counted_;
  SpatialImpedance follower_;
  NewestOf<SpatialDatagram> newest_;
  std::optional<Vec3> follower_before_;  // [m]
};

}  // namespace feltwire::teleop
