#pragma once
// How much an error may show of a file that a scene names. The writer of a scene chooses which
// files the server reads, by a path or by a link; errors must not show the contents of other
// files.
//
// The rule: an error quotes a file only if the file, its links followed, lies in the folder of the
// scene's file or below it. Of any other file it gives only the name and the line or byte.

#include <filesystem>
#include <string>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// `message` as it is, or where `file` lies outside of `folder` only as far as its line or byte.
/// Messages about a file begin with its name; those that name neither line nor byte quote nothing.
std::string shown_error(const std::string& message, const std::filesystem::path& file,
                        const std::filesystem::path& folder);

/// The same of an error about an MJCF file: it may quote any file that the MJCF file names.
std::string shown_mjcf_error(const std::string& message, const std::filesystem::path& file,
                             const std::filesystem::path& folder);

/// A mesh that a scene in `folder` names. Throws FileError as read_mesh() does, shown by the rule.
TriangleSoup read_scene_mesh(const std::filesystem::path& folder, const std::string& name,
                             double scale);

}  // namespace feltwire
