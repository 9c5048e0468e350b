#pragma once

namespace feltwire {

/// `feltwire-server token add|list|revoke ...`: argv[0] is "token". Returns the exit status, after
/// it has printed an error in one line.
int token_command(int argc, char** argv);

}  // namespace feltwire
