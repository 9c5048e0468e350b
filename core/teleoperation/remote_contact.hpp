#pragma once
// The surfaces of a robot's surroundings, as its estimate tells them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/types.hpp"

namespace feltwire {

/// A surface that the robot touches, or touched before. World frame of the robot.
struct RemoteContact {
  std::uint32_t surface = 0;     // counts surfaces; 0: none is known
  bool touching = false;         // now, or less than ContactEstimator::kApart ago
  Vec3 point = Vec3::Zero();     // [m] on the surface, where the force would be zero
  Vec3 normal = Vec3::UnitX();   // unit, towards the free side
  double stiffness = 0.0;        // [N/m] > 0 of the surface, along the normal
  double friction = 0.0;         // mu, from the force while the tool slid; 0: it has not slid yet
  Vec3 velocity = Vec3::Zero();  // [m/s] of the surface along its normal
};

/// Surfaces besides that of the contact, which the robot touched before and which are still near
/// its tool, the nearest first. They stand still, and the robot does not touch them.
struct OtherSurfaces {
  static constexpr int kMost = 2;  // a local model has three patches

  std::array<RemoteContact, kMost> surfaces{};
  int count = 0;

  std::span<const RemoteContact> view() const noexcept {
    return {surfaces.data(), static_cast<std::size_t>(count)};
  }
};

}  // namespace feltwire
