#include "protocol/session/role.hpp"

#include "core/base/choice.hpp"

namespace feltwire {

std::string_view name(Role role) { return name_among(kRoleNames, role); }
Role role(std::string_view given) { return chosen_value<Role>("role", given, kRoleNames); }

}  // namespace feltwire
