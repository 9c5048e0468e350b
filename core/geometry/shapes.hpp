#pragma once
// All shapes that can be felt.

#include <memory>
#include <string>
#include <variant>

#include "core/geometry/box.hpp"
#include "core/geometry/capsule.hpp"
#include "core/geometry/cone.hpp"
#include "core/geometry/cylinder.hpp"
#include "core/geometry/plane.hpp"
#include "core/geometry/sphere.hpp"
#include "core/geometry/torus.hpp"

namespace feltwire {

template <Primitive... Shapes>
struct PrimitiveList {
  /// A variant of some other types, the shapes of this list, and some more.
  template <class... Others>
  struct After {
    template <class... More>
    using And = std::variant<Others..., Shapes..., More...>;
  };
  template <class... More>
  using And = std::variant<Shapes..., More...>;

  /// Calls f with one shape of each kind.
  template <class Call>
  static void for_each(Call f) {
    (f(Shapes{}), ...);
  }
};

/// The shapes with a formula: each is a line here and a file with all of its code.
using Primitives = PrimitiveList<Plane, Sphere, Box, Capsule, Cylinder, Cone, Torus>;

class MeshSurface;
/// Triangles, with the data that a hand needs to move on them; shared, immutable.
struct Mesh {
  std::shared_ptr<const MeshSurface> surface;  // never null in a scene
};
template <class Real>
class DistanceGrid;
/// A distance field, sampled (core/grid/distance_grid.hpp).
struct Grid {
  std::shared_ptr<const DistanceGrid<float>> field;  // never null
};
using Shape = Primitives::And<Mesh, Grid>;

/// Calls call(primitive) for the primitive that a variant holds, otherwise otherwise(). For the
/// servo loop: unlike std::visit it never throws.
template <std::size_t kFirst = 0, class Variant, class Call, class Otherwise>
auto on_primitive(const Variant& shape, Call&& call, Otherwise&& otherwise) {
  if constexpr (kFirst < std::variant_size_v<Variant>) {
    if constexpr (Primitive<std::variant_alternative_t<kFirst, Variant>>) {
      if (const auto* primitive = std::get_if<kFirst>(&shape)) return call(*primitive);
    }
    return on_primitive<kFirst + 1>(shape, call, otherwise);
  } else {
    return otherwise();
  }
}

/// Whether a shape is bounded: all primitives except a plane are.
template <Primitive Solid>
bool is_bounded(const Solid& solid) noexcept {
  return solid.half_box().allFinite();
}

/// The names of all primitives for a sentence: "plane, sphere, ...". `bounded`: only those that are
/// bounded.
std::string names_of_primitives(bool bounded);

}  // namespace feltwire
