#pragma once
// A point shell against solids: a penalty for each point inside.

#include "core/contact/contact.hpp"
#include "core/point_shell/point_shell.hpp"
#include "core/tool_coupling/tool_contact.hpp"

namespace feltwire {

/// An object in a step.
struct ObjectInStep {
  std::uint32_t index = 0;      // in the scene
  double share = 1.0;           // of its force that is felt
  Vec6 carried = Vec6::Zero();  // as FrictionPatch::carried
};

/// Adds the contact with one object. Each point inside, at signed distance d < 0, stores
///   U = k / (2 A_c) * (A / N) * d^2,    force = -k A / (A_c N) * d * grad d,
/// k the material's stiffness, A / N the area that the point stands for, A_c the contact area
/// [m^2], > 0: where that much of the tool presses flat on a solid, it meets the stiffness k. So
/// the force is an integral over the tool's surface (a bed of springs, Winkler 1867): more points
/// make it more exact, not larger. The force is the gradient of a potential wherever the distance
/// is that of a grid. Values for friction and damping are stored beside it; a material without
/// them costs nothing more.
///
/// With more patches or touched objects than kFrictionPatches, the last one takes all further ones.
/// Poses must be finite. Where `work` is cut off, the sum means nothing. Never allocates.
void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum, const ObjectInStep& in = {},
                 WorkLimit* work = nullptr) noexcept;

}  // namespace feltwire
