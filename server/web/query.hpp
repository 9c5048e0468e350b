#pragma once
// The query of a request: `scene=room&ticket=...`.

#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

/// The value of the first field of this name, %-escapes resolved. Empty if there is none, or if an
/// escape is malformed.
std::optional<std::string> query_value(std::string_view query, std::string_view name);

}  // namespace feltwire
