#pragma once
// The lab's two filters: CSV in, CSV out, for people and scripts.

#include <iosfwd>
#include <optional>
#include <string>

#include "client/hands/plant.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// `feltwire-lab bound`. In: dx,dy,dz [m], ex,ey,ez [N] elastic and fx,fy,fz [N] frictional
/// command, on the hand. Out: rx,ry,rz [N] rendered, energy [J] delivered to the hand so far (sum
/// of f(n-1).dx(n)), active (0/1). If the configuration has rotation, also in: ax,ay,az [rad] the
/// rotation vector since the last row, tx,ty,tz [N m]; out: rtx,rty,rtz [N m] rendered, and energy
/// is that of all six degrees of freedom. With an account, which stands after the method: the force
/// that it gives, and its balance [J] last. With an amplifier: also motor [J], at the very end, the
/// energy that its true force and torque gave so far if each row's movement was even. Optional in:
/// hold [s] since the last row (else the period); local, 1 for a command that was computed at the
/// device's present place (else 0); n1x,n1y,n1z to n3x,n3y,n3z, normals of the walls (else none).
/// Numbers that are not finite are read, and render zero. Returns how many rows were refused for
/// that. Throws CsvError for a field that is not a number, for a hold, a local or a normal that
/// cannot be.
std::size_t filter_bound(std::istream& in, std::ostream& out, const BoundingConfig& config,
                         const std::optional<AccountConfig>& account_config = {},
                         const std::optional<Plant::Amplifier>& amplifier = {});

/// `feltwire-lab touch`. In: t [s], x,y,z [m]; for a tool with a body also qw,qx,qy,qz, its
/// orientation. Out: ex,ey,ez,fx,fy,fz [N], the scene's force there, on the hand; for a tool with a
/// body also tx,ty,tz [N m]. `tool`: the name of one of the scene's tools; empty: the first. The
/// rows are one movement: friction, contact and velocity (the difference of two rows) have memory.
/// Returns how many rows were not finite (zero force). Throws CsvError for a field that is not a
/// number, for times that do not grow and for a body without an orientation, std::invalid_argument
/// if the scene has no such tool.
std::size_t filter_touch(std::istream& in, std::ostream& out, const Scene& scene,
                         const std::string& tool = {});

}  // namespace feltwire
