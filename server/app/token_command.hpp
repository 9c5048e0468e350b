#pragma once

namespace feltwire {

/// `feltwire-server token add|list|revoke ...`: argv[0] is "token". The exit status; what is wrong
/// has been said in one line.
int token_command(int argc, char** argv);

}  // namespace feltwire
