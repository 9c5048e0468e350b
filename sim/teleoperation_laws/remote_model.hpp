#pragma once

#include <optional>

#include "core/bounding/account.hpp"
#include "core/bounding/midpoint.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/contact_estimate.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/surface_index.hpp"
#include "core/teleoperation/target_limiter.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// feltwire's own law, of the parts that sessions use: the follower estimates what it touches; the
/// leader renders that as a local model, half a sample ahead, behind the account of its port, which
/// the energy that the environment gave is credited to.
/// docs/teleoperation.md has the law and the proof.
class RemoteModel final : public TeleoperationLaw {
 public:
  explicit RemoteModel(const Plant& plant);
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override;
  double offset() const override { return index_.offset().x(); }

 private:
  void show(const RemoteContact& contact, double now);

  Plant plant_;
  // The leader.
  Newest from_follower_;
  SurfaceIndex index_;
  LocalContact local_;
  Midpoint<double> midpoint_;
  PortAccount account_;
  RemoteEnergy remote_;
  Vec3 held_ = Vec3::Zero();         // [N] on the hand
  std::optional<Vec3> hand_before_;  // [m]
  double hand_work_ = 0.0;           // [J]
  // The follower.
  Newest from_leader_;
  ContactEnergy counted_;
  ContactEstimate estimate_;
  TargetLimiter limiter_;
  std::optional<Vec3> tip_before_, target_before_;  // [m]
  double target_speed_ = 0.0;                       // [m/s]
};

}  // namespace feltwire::teleop
