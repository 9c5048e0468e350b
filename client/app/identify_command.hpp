#pragma once

namespace feltwire {

/// `feltwire-client identify ...`: measures a device that nobody holds, and writes its file for
/// --spec. The words begin with `identify`. Returns the exit status: 0; 1 if it stopped, and no
/// file was written; 2 for a wrong command line.
int identify_command(int argc, char** argv);

}  // namespace feltwire
