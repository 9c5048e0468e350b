#include "protocol/session/role.hpp"

#include <stdexcept>
#include <string>

namespace feltwire {

std::string_view name(Role role) { return kRoleNames.at(static_cast<std::size_t>(role)); }

Role role(std::string_view name) {
  for (std::size_t i = 0; i < kRoleNames.size(); ++i)
    if (kRoleNames.at(i) == name) return static_cast<Role>(i);
  throw std::invalid_argument("'" + std::string(name) +
                              "' is no role; choose observer, operator or admin");
}

}  // namespace feltwire
