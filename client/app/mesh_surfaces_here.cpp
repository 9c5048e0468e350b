#include "client/app/surfaces.hpp"
#include "core/whole_surfaces/mesh_surfaces.hpp"

namespace feltwire {

BuildSurfaces surface_builder() { return mesh_surfaces; }

}  // namespace feltwire
