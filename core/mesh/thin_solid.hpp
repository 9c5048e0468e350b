#pragma once
// Solids of triangles that are too thin for their size.

#include <optional>
#include <string>

#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// A warning where a closed surface is thinner than some skins (MeshSurface::skin()), so that its
/// two sides cannot be told apart and a hand may pass through. Says both lengths and the remedy.
/// Nothing for open surfaces and for thicker ones.
std::optional<std::string> warning_of_thin_solid(const MeshSurface& surface);

}  // namespace feltwire
