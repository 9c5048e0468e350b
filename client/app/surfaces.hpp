#pragma once

#include "core/local_model/whole_surfaces.hpp"

namespace feltwire {

/// Makes whole surfaces where this program was built with core/whole_surfaces; else empty.
BuildSurfaces surface_builder();

}  // namespace feltwire
