#pragma once
// The rules for the numbers of a coupled tool.

#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// Each throws std::invalid_argument that names the field and the remedy, if a number is not
/// possible. Of a coupling nothing may be zero; an inertia of mass 0 is always possible.
void check(const ToolCoupling& coupling);
void check(const ToolInertia& inertia);
/// 0 < value, finite. `unit`: "[m^2]".
void require_above_zero(const char* field, double value, const char* unit);

}  // namespace feltwire
