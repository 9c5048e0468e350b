#pragma once
// Limits the part of a file that an error quotes. The writer of a scene chooses which files the
// server reads, by a path or by a link; errors must not show the contents of other files.
//
// The rule: an error quotes a file only if the file, its links followed, lies in the folder of the
// scene's file or below it. Of any other file it gives only the name and the line or byte.

#include <filesystem>
#include <string>

#include "core/base/file_error.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// Whether a file, its links followed, lies neither in the folder nor below it. False if the
/// calling thread reads only given files (core/base/captured_files.hpp), because they are not on
/// this disk.
bool lies_outside(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Returns `message`. If `file` lies outside of `folder`, it is cut after the line or byte.
/// Messages about a file begin with its name; those that name neither line nor byte quote nothing.
std::string shown_error(const std::string& message, const std::filesystem::path& file,
                        const std::filesystem::path& folder);

/// Does so for an error about an MJCF or URDF file. MuJoCo's words may quote any file that this
/// file names; if one of them lies outside, they are not shown. feltwire's own reasons
/// (RefusedModel) are always shown, without the names in the model if its text lies outside. A file
/// that is named and does not exist, or holds something else, is said to.
std::string shown_mjcf_error(const FileError& error, const std::filesystem::path& file,
                             const std::filesystem::path& folder);

/// Reads a mesh that a scene in `folder` names. Throws FileError as read_mesh() does, cut by the
/// rule above.
TriangleSoup read_scene_mesh(const std::filesystem::path& folder, const std::string& name,
                             double scale);

}  // namespace feltwire
