#pragma once

namespace feltwire {

/// `feltwire-server fleet ...`: shows a fleet as its directory has it, or moves its scenes. Returns
/// the exit status.
int fleet_command(int argc, char** argv);

}  // namespace feltwire
