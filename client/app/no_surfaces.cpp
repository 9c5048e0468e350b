// For the thin client, which is built without meshes.

#include "client/app/surfaces.hpp"

namespace feltwire {

BuildSurfaces surface_builder() { return {}; }

}  // namespace feltwire
