#pragma once
// Coulomb friction of a tool without mass: its movement, and the friction on it.

#include "core/base/work_limit.hpp"
#include "core/tool_coupling/tool_contact.hpp"

namespace feltwire {

/// The motion of the tool, and the friction on it.
struct FrictionSolution {
  Vec6 motion = Vec6::Zero();  // [m], [rad]
  std::array<Vec6, ShellContact::kFrictionPatches>
      friction{};      // [N], [N m] on the tool, of each patch
  bool slips = false;  // not all patches hold
};

/// The motion m that minimises
///   m^T stiffness m / 2 - wrench^T m + sum over patches of mu load |m - carried|,
/// where |m|^2 = m^T slip m. This is Moreau's sweeping process of a quasi-static body; the limit
/// surface of each patch is an ellipsoid (Goyal, Ruina & Papadopoulos 1991; Howe & Cutkosky 1996).
/// The root mean square is never below the mean, so the magnitudes of a patch's forces along the
/// surface sum up to at most mu load, and to exactly that where all points slip equally far. A
/// patch that holds moves by no more than kHeld. mu is the dynamic friction where `slipping`, else
/// the static one. `stiffness` must be positive definite. Where `work` is cut off, the result means
/// nothing. Never allocates.
FrictionSolution solve_friction(const Mat6& stiffness, const Vec6& wrench,
                                std::span<const FrictionPatch> patches, bool slipping,
                                WorkLimit* work = nullptr) noexcept;

/// [J] The last sum above: the work of the motion against friction.
double friction_work(std::span<const FrictionPatch> patches, bool slipping,
                     const Vec6& motion) noexcept;

inline constexpr double kHeld = 1e-9;  // [m] a step

}  // namespace feltwire
