#pragma once
// Laws of other papers, for studies: they are no methods of a session, and the registry does not
// know them. Each has its source in its own header beside this one.

#include <span>

#include "core/bounding/method.hpp"

namespace feltwire {

std::span<const BoundingMethod> published_laws();

/// The law of that name, one of these or of the registry. Throws std::invalid_argument naming the
/// registry's when there is none.
const BoundingMethod& law(std::string_view name);

}  // namespace feltwire
