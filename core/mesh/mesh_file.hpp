#pragma once
// Surfaces from files: OBJ, STL (text and binary), PLY (text and binary, either byte order).

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/file_error.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// The surface in a file, its format by the file's ending, coordinates as written times `scale` [m
/// per unit of the file]. Polygons of more than three corners are cut into a fan. Throws FileError
/// with file, line (in binary files: byte) and remedy for whatever does not fit, a vertex farther
/// than 1e6 m from the origin included, and never reads past a field that it does not understand:
/// nothing of a surface is left out silently.
TriangleSoup read_mesh(const std::filesystem::path& file, double scale);

/// The same from bytes; `name` is what errors call them and its ending the format.
TriangleSoup parse_mesh(std::string_view bytes, const std::string& name, double scale);

// The formats, in units of the file; `scale` [m per unit] says how far a vertex may lie.
TriangleSoup parse_obj(std::string_view bytes, const std::string& name, double scale = 1.0);
TriangleSoup parse_stl(std::string_view bytes, const std::string& name, double scale = 1.0);
TriangleSoup parse_ply(std::string_view bytes, const std::string& name, double scale = 1.0);

/// A surface as an OBJ file [m], as many digits as a double has.
std::string obj_text(const TriangleSoup& soup);

}  // namespace feltwire
