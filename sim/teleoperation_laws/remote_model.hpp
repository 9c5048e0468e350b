#pragma once

#include <optional>
#include <utility>

#include "sim/teleoperation_laws/remote_ends.hpp"
#include "sim/teleoperation_laws/spatial_law.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// The velocity of the robot's target, low-passed, for the damper of its controller.
class TargetVelocity {
 public:
  /// Returns it for the target [m] of this sample [m/s].
  const Vec3& step(const Vec3& target, double period);

 private:
  std::optional<Vec3> before_;    // [m]
  Vec3 velocity_ = Vec3::Zero();  // [m/s]
};

/// feltwire's own law along one axis: RemoteLeader and RemoteFollower. With a prior, a plane across
/// that axis is known before it is touched.
/// docs/teleoperation.md has the law and the proof.
class RemoteModel final : public TeleoperationLaw {
 public:
  explicit RemoteModel(const Plant& plant, const SurfacePrior& prior = {})
      : plant_(plant), prior_(prior), leader_(plant), follower_(plant) {}
  double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
              Datagram& out) override;
  FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                       Datagram& out) override;
  double offset() const override { return leader_.offset().x(); }

 private:
  Plant plant_;
  SurfacePrior prior_;
  Newest from_follower_, from_leader_;
  RemoteLeader leader_;
  RemoteFollower follower_;
  TargetVelocity target_velocity_;
};

/// feltwire's own law in three degrees of freedom. `model` gives the surfaces that are known before
/// the robot touches them. Without a model no surface is known.
class SpatialRemoteModel final : public SpatialLaw {
 public:
  explicit SpatialRemoteModel(const Plant& plant, SurfaceModel model = {})
      : plant_(plant), model_(std::move(model)), leader_(plant), follower_(plant) {}
  Vec3 lead(const SpatialLeaderSample& sample, std::span<const SpatialDatagram> arrived,
            SpatialDatagram& out) override;
  SpatialFollowerForce follow(const SpatialFollowerSample& sample,
                              std::span<const SpatialDatagram> arrived,
                              SpatialDatagram& out) override;
  Vec3 offset() const override { return leader_.offset(); }

 private:
  Plant plant_;
  SurfaceModel model_;
  NewestOf<SpatialDatagram> from_follower_, from_leader_;
  RemoteLeader leader_;
  RemoteFollower follower_;
  TargetVelocity target_velocity_;
};

}  // namespace feltwire::teleop
