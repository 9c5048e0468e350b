#pragma once
// Coulomb friction of a tool without mass: which way it moves, and what holds it back.

#include "core/tool/shell_contact.hpp"

namespace feltwire {

/// How the tool moves, and what friction gives it.
struct FrictionSolution {
  Vec6 motion = Vec6::Zero();  // [m], [rad]
  std::array<Vec6, ShellContact::kFrictionPatches>
      friction{};      // [N], [N m] on the tool, of each patch
  bool slips = false;  // not all patches hold
};

/// The motion m that makes least of
///   m^T stiffness m / 2 - wrench^T m + sum over patches of mu load |m - carried|,
/// |m|^2 = m^T slip m: Moreau's sweeping process of a quasi-static body, each patch with an
/// ellipsoid for its limit surface (Goyal, Ruina & Papadopoulos 1991; Howe & Cutkosky 1996). The
/// root of the mean square is not below the mean, so a patch's forces along the surface sum up,
/// each by its magnitude, to no more than mu load; it is just that where all points slip equally
/// far. A patch that holds gives way by no more than kHeld. mu is the dynamic or the static one.
/// `stiffness` must be positive definite. Never allocates.
FrictionSolution solve_friction(const Mat6& stiffness, const Vec6& wrench,
                                std::span<const FrictionPatch> patches, bool slipping) noexcept;

/// [J] The last of these sums: what the motion costs.
double friction_work(std::span<const FrictionPatch> patches, bool slipping,
                     const Vec6& motion) noexcept;

inline constexpr double kHeld = 1e-9;  // [m] a step

}  // namespace feltwire
