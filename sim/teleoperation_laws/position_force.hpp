#pragma once

#include <memory>
#include <optional>

#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/two_port_bound.hpp"
#include "sim/teleoperation_laws/impedance_follower.hpp"

namespace feltwire::teleop {

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
  /// `method`: a bounding method of the registry, "none" for no bound.
  PositionForce(const Plant& plant, std::string_view method);
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override {
    return follower_.step(sample, arrived, out);
  }

 private:
  double period_;
  Bounding bound_;
  ImpedanceFollower follower_;
  Newest newest_;
  std::optional<double> before_;  // [m]
};

/// P-F behind the two-port law (T) (core/teleoperation/two_port_bound.hpp): as with contact_frame,
/// and a remote that moves may push the hand.
class PositionForceTwoPort final : public TeleoperationLaw {
 public:
  explicit PositionForceTwoPort(const Plant& plant);
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override;

 private:
  double period_;
  TwoPortBound bound_;
  RemoteEnergy remote_;
  ContactEnergy counted_;
  ImpedanceFollower follower_;
  Newest newest_;
  std::optional<double> before_, follower_before_;  // [m]
  double held_ = 0.0;                               // [N]
};

}  // namespace feltwire::teleop
