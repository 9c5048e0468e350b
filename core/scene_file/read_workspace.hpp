#pragma once
// Internal to the readers of a scene file: the workspace of a robot's seat.

#include "core/scene_file/read_values.hpp"

namespace feltwire {

/// Fills the seat's workspace, and the properties of its walls. `path` of the workspace in the
/// file. Throws FileError that names the field if one cannot be read; check(RemoteSeat) checks the
/// rest.
void read_workspace(const JsonDocument& document, const std::string& path,
                    const scene_file::Workspace& from, RemoteSeat& seat);

}  // namespace feltwire
