#pragma once
// Meshes that a client has in full: what the server sends of them, and the contact with them.

#include <memory>
#include <optional>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/local_model/prefetched_geometry.hpp"

namespace feltwire {

/// Whether surface_data() gives something: a mesh without a height map.
bool can_travel(const Object& object) noexcept;

/// An object as it travels, without its vertices and triangles; empty: it cannot. `ball` [m]: the
/// radius of the tool, which the mesh gets besides its own; 0: a point. Precondition: `index` is
/// that of the object in its scene.
std::optional<SurfaceData> surface_data(const Object& object, std::uint16_t index, double ball);
/// With vertices and triangles. Precondition: can_travel(object).
SurfaceData surface_data_with_triangles(const Object& object, std::uint16_t index, double ball);

/// Makes the surfaces of a scene ready for touch(). Their triangles keep their numbers: it throws
/// std::invalid_argument if a surface has triangles that a mesh of a scene cannot have.
std::shared_ptr<const PrefetchedSurfaces> mesh_surfaces(std::uint32_t version,
                                                        const std::vector<SurfaceData>& surfaces);

}  // namespace feltwire
