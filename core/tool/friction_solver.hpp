#pragma once
// Coulomb friction of a tool without mass: which way it moves, and what holds it back.

#include "core/tool/shell_contact.hpp"

namespace feltwire {

/// How the tool moves, and what friction gives it.
struct Slide {
  Vec6 motion = Vec6::Zero();                         // [m], [rad]
  std::array<Vec6, ShellContact::kGrips> friction{};  // [N], [N m] on the tool, of each grip
  bool slips = false;                                 // not all grips hold
};

/// The motion m that makes least of
///   m^T stiffness m / 2 - wrench^T m + sum over grips of mu load |m - carried|,
/// |m|^2 = m^T slip m: Moreau's sweeping process of a quasi-static body, each grip with an
/// ellipsoid for its limit surface (Goyal, Ruina & Papadopoulos 1991; Howe & Cutkosky 1996). The
/// root of the mean square is not below the mean, so a grip's forces along the surface sum up, each
/// by its magnitude, to no more than mu load; it is just that where all points slip equally far. A
/// grip that holds gives way by no more than kHeld. mu is the dynamic or the static one.
/// `stiffness` must be positive definite. Never allocates.
Slide slide(const Mat6& stiffness, const Vec6& wrench, std::span<const Grip> grips,
            bool slipping) noexcept;

/// [J] The last of these sums: what the motion costs.
double slide_work(std::span<const Grip> grips, bool slipping, const Vec6& motion) noexcept;

inline constexpr double kHeld = 1e-9;  // [m] a step

}  // namespace feltwire
