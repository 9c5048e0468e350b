#pragma once

namespace feltwire {

/// `feltwire-client admin ...`: shows and changes a running server. The words begin with `admin`.
/// Returns the exit status: 0; 1 if the server refused or is not there; 2 for a wrong command line.
/// Errors are one line on stderr.
int admin_command(int argc, char** argv);

}  // namespace feltwire
