#pragma once
// Surfaces from files: OBJ, STL (text and binary), PLY (text and binary, either byte order).

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/file_error.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// Reads the surface in a file. The file's ending says the format. Coordinates are multiplied by
/// `scale` [m per unit of the file]. Polygons of more than three corners are cut into a fan. Throws
/// FileError with the file, the line (in binary files: the byte) and the remedy if anything does
/// not fit, such as a vertex more than 1e6 m from the origin. No part of a surface is left out
/// silently: a field that is not understood is an error.
TriangleSoup read_mesh(const std::filesystem::path& file, double scale);

/// Like read_mesh(), from bytes. Errors call them `name`; its ending says the format.
TriangleSoup parse_mesh(std::string_view bytes, const std::string& name, double scale);

// A function for each format. The result is in units of the file. `scale` [m per unit] only serves
// to check how far a vertex lies.
TriangleSoup parse_obj(std::string_view bytes, const std::string& name, double scale = 1.0);
TriangleSoup parse_stl(std::string_view bytes, const std::string& name, double scale = 1.0);
TriangleSoup parse_ply(std::string_view bytes, const std::string& name, double scale = 1.0);

/// A surface as the text of an OBJ file [m], with all digits of a double.
std::string obj_text(const TriangleSoup& soup);

}  // namespace feltwire
