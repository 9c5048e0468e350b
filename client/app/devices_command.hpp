#pragma once

namespace feltwire {

/// `feltwire-client devices`: lists the connected devices, the libraries that the drivers need, and
/// the problems. The words begin with `devices`. Returns the exit status: 0; 1 if a problem was
/// found; 2 for a wrong command line.
int devices_command(int argc, char** argv);

}  // namespace feltwire
