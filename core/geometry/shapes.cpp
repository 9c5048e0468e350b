#include "core/geometry/shapes.hpp"

namespace feltwire {

std::string names_of_primitives(bool bounded) {
  std::string names;
  Primitives::for_each([&](const auto& primitive) {
    if (bounded && !is_bounded(primitive)) return;
    names += (names.empty() ? "" : ", ") + std::string(primitive.kName);
  });
  return names;
}

}  // namespace feltwire
