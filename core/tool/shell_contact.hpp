#pragma once
// A point shell against solids: a penalty for each point inside.

#include <limits>

#include "core/contact/contact.hpp"
#include "core/tool/point_shell.hpp"

namespace feltwire {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// What the solids answer a shell with. Generalised vectors are translation, then rotation, world
/// frame, about the tool's origin.
struct ShellContact {
  double energy = 0.0;            // [J] stored in the solids
  Vec6 wrench = Vec6::Zero();     // [N], [N m] on the tool: minus the gradient of the energy
  Mat6 stiffness = Mat6::Zero();  // [N/m] ... Gauss-Newton part of the energy's second derivative
  double clearance = std::numeric_limits<double>::infinity();  // [m] no free point is nearer to a
                                                               // surface than this
  std::size_t touching = 0;                                    // points inside a solid
  std::size_t looked_at = 0;  // nodes and points that a distance was asked for
};

/// Adds what one object answers. Each point inside, at signed distance d < 0, stores
///   U = k / (2 A_c) * (A / N) * d^2,    force = -k A / (A_c N) * d * grad d,
/// k the material's stiffness, A / N the area that the point stands for, A_c the contact area
/// [m^2], > 0: where that much of the tool presses flat on a solid, it meets the stiffness k. So
/// the force is an integral over the tool's surface (a bed of springs, Winkler 1867): more points
/// make it more exact, not larger. It is the gradient of a potential wherever the distance is that
/// of a grid, and friction and damping have no part in it. Poses must be finite. Never allocates.
void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum) noexcept;

}  // namespace feltwire
