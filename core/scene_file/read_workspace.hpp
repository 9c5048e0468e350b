#pragma once
// Internal to the readers of a scene file: the workspace of a robot's seat.

#include "core/scene_file/read_values.hpp"

namespace feltwire {

/// Fills the seat's workspace, and how its walls are felt. Throws FileError naming the field, where
/// one cannot be read; check(RemoteSeat) has the rest.
void read_workspace(const JsonDocument& document, const scene_file::Workspace& from,
                    RemoteSeat& seat);

}  // namespace feltwire
