#pragma once
// A point shell against solids: a penalty for each point inside.

#include "core/contact/contact.hpp"
#include "core/coupled_tool/point_shell.hpp"
#include "core/coupled_tool/tool_contact.hpp"

namespace feltwire {

/// One object in one step.
struct ObjectInStep {
  std::uint32_t index = 0;      // in the scene
  double share = 1.0;           // of its force that is felt
  Vec6 carried = Vec6::Zero();  // as FrictionPatch::carried
};

/// Adds the contact with one object, as add_shell_contact() (core/coupled_tool/shell_query.hpp).
/// Poses must be finite. Never allocates.
void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum, const ObjectInStep& in = {}) noexcept;

}  // namespace feltwire
