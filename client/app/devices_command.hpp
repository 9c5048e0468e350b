#pragma once

namespace feltwire {

/// `feltwire-client devices`: what is plugged in, what the drivers look for, and what stands in the
/// way. The words begin with `devices`. Returns the exit status: 0; 1 where a problem was found; 2
/// for a wrong command line.
int devices_command(int argc, char** argv);

}  // namespace feltwire
