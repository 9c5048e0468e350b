#pragma once

#include <optional>

#include "sim/teleoperation_laws/remote_ends.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

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
  std::optional<Vec3> target_before_;  // [m]
  double target_speed_ = 0.0;          // [m/s]
};

}  // namespace feltwire::teleop
