#include "protocol/session/role.hpp"

#include "core/base/enum_names.hpp"

namespace feltwire {

std::string_view name(Role role) { return enum_name(kRoleNames, role); }
Role role(std::string_view given) { return enum_from_name<Role>("role", given, kRoleNames); }

}  // namespace feltwire
