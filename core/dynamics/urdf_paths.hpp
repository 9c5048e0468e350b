#pragma once
// Paths of meshes in a URDF file, as its other readers understand them.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace feltwire {

/// Whether a name is a URI that file_of_uri() knows: package:// or file://.
bool is_file_uri(std::string_view name);

/// The file that a URI names. package://NAME/rest stands in a folder NAME beside the file that
/// names it (in `folder`) or up to three folders above, or in one of another name. file:// begins a
/// path. Empty: there is no such file.
std::optional<std::filesystem::path> file_of_uri(std::string_view uri,
                                                 const std::filesystem::path& folder);

/// Whether an XML text is a URDF file: its root is <robot>.
bool is_urdf(std::string_view xml);

/// MuJoCo drops the folders from the paths of a URDF file, unless its <mujoco><compiler> says
/// strippath="false", and it does not know package:// paths. Returns the text with this option, and
/// with each package:// path replaced by that of the file, which is looked for beside the URDF file
/// (in `folder`) and in the folders above. Lines keep their numbers. Empty: the text needs no
/// change, is no URDF file, or says strippath or a folder of meshes itself.
std::optional<std::string> with_paths_kept(const std::string& xml,
                                           const std::filesystem::path& folder);

}  // namespace feltwire
