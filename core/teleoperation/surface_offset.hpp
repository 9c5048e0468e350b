#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/workspace.hpp"

namespace feltwire {

struct SurfaceOffsetRole {
  bool holds = false;  // the offset is not given back now
  bool meets = true;   // the offset takes up a first touch; false: that of another leader does
};

/// The leader's offset: the robot's target is the hand's position less `offset()`.
///
/// The leader knows of a first touch one round trip late, when the hand is already far inside the
/// surface. Then the offset moves along the normal until the surface is at the hand. So the hand
/// meets the surface there, and no force jumps. For kYoung after that the surface stays at the hand
/// while the estimate of its place settles; the offset takes up the change. A surface that was
/// known before its touch (SurfacePrior) stays where the model has it; kYoung begins with the
/// touch. The same holds for a surface beside the contact that is told for the first time. A
/// contact that changes from one known surface to another moves no offset. A surface that has left
/// (ContactEstimator) is met where it is when it comes back. Later the offset is given back by a
/// hardly noticeable share of the hand's free movement, in front of all surfaces.
///
/// A hand that moves on behind a wall of the robot's workspace takes the offset along. So the
/// wanted place of the robot is at the wall, and the robot follows at once when the hand comes
/// back.
///
/// The offset is sent in every sample, so that both sides have the same. No function allocates,
/// throws or reads a clock.
class SurfaceOffset {
 public:
  static constexpr double kYoung = 0.1;       // [s]
  static constexpr double kGivenBack = 0.2;   // of free movement
  static constexpr double kFreeAbove = 5e-3;  // [m] from the surface
  static constexpr double kFarthest = 1e3;    // [m] on each axis, by walls that are far away

  /// The hand moved by `displacement` [m] to `hand` in `elapsed` [s]. `seen` is the newest contact
  /// that the leader knows, `others` are the surfaces beside it. All are finite.
  void step(const Vec3& hand, const Vec3& displacement, const RemoteContact& seen, double elapsed,
            const SurfaceOffsetRole& role = {}, const OtherSurfaces& others = {}) noexcept {
    const double height = height_of(seen, hand);
    const bool known = seen.surface != 0 && knows(seen.surface);
    if (known && seen.surface != contact_) {
      age_ = kYoung;  // it was met before
      touched_ = true;
      place_ = seen.point;
    }
    const double back = (place_ - seen.point).dot(seen.normal);
    const bool left = known && !seen.touching && back > ContactEstimator::kSame;
    if (left) age_ = kYoung;
    // A surface that a model of the environment told before has its place from the first touch on.
    const bool first = seen.touching && !touched_;
    const bool young = known && (touched_ || first) && age_ < kYoung;
    const bool beside = std::ranges::any_of(others.view(), [&](const RemoteContact& other) {
      return height_of(other, hand) < kFreeAbove;
    });
    const bool free = known && !young && height > kFreeAbove && !seen.touching && !beside;
    if (seen.surface == 0 || free) {
      if (!role.holds && !beside) give_back(displacement);
    } else if (!known) {
      if (height < 0.0 && role.meets) offset_ += height * seen.normal;
      age_ = role.meets ? 0.0 : kYoung;
      touched_ = false;
    } else if (young) {
      if (height < kFreeAbove) offset_ -= along(seen.point - place_, seen.normal);
      age_ += elapsed;
    }
    touched_ = seen.surface != 0 && (touched_ || seen.touching);
    for (const RemoteContact& other : others.view())
      if (role.meets && !knows(other.surface))
        offset_ += std::min(0.0, height_of(other, hand)) * other.normal;
    contact_ = seen.surface;
    place_ = seen.point;
    others_ = {};
    for (int i = 0; i < others.count; ++i)
      others_[static_cast<std::size_t>(i)] = others.surfaces[static_cast<std::size_t>(i)].surface;
  }

  /// From now on the wanted place of the robot is in front of these walls, which are given in the
  /// hand's frame.
  void keep_in_front(const Vec3& hand, std::span<const WorkspaceWall> walls) noexcept {
    const Vec3 wanted = hand - offset_;
    const Vec3 offset = hand - nearest_in_front(wanted, walls);
    if (offset.cwiseAbs().maxCoeff() <= kFarthest) offset_ = offset;
  }

  const Vec3& offset() const noexcept { return offset_; }  // [m]
  /// The greatest number of those that it knows; 0: none.
  std::uint32_t known_surface() const noexcept {
    return std::max(contact_, std::ranges::max(others_));
  }

 private:
  bool knows(std::uint32_t surface) const noexcept {
    return surface == contact_ || std::ranges::find(others_, surface) != others_.end();
  }
  /// [m] of the hand above the surface.
  double height_of(const RemoteContact& surface, const Vec3& hand) const noexcept {
    return (hand - offset_ - surface.point).dot(surface.normal);
  }
  void give_back(const Vec3& displacement) noexcept {
    const Polar<double> left = polar(offset_);
    const double back = std::min(left.length, kGivenBack * length(displacement));
    offset_ -= back * left.direction;
  }

  Vec3 offset_ = Vec3::Zero();
  std::uint32_t contact_ = 0;  // the surface of the contact in the last step
  std::array<std::uint32_t, OtherSurfaces::kMost> others_{};
  double age_ = 0.0;           // [s] since the surface was touched and known
  bool touched_ = false;       // the surface, since it is known
  Vec3 place_ = Vec3::Zero();  // [m] of the surface in the last step
};

}  // namespace feltwire
