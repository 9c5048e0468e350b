#pragma once
// Laws of other papers, for studies. They are not methods of a session, and not in the registry.
// Each has its source in its own header.

#include <span>

#include "core/bounding/method.hpp"

namespace feltwire {

std::span<const BoundingMethod> published_laws();

/// The law with that name, one of these or of the registry. Throws std::invalid_argument that lists
/// the registry's names if there is none.
const BoundingMethod& law(std::string_view name);

}  // namespace feltwire
