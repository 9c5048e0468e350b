#pragma once

namespace feltwire {

/// Exit codes of feltwire-server: the command line or a file is wrong; the work could not be done.
inline constexpr int kBadUsage = 2, kCannotRun = 1;

/// `feltwire-server token add|list|revoke ...`: argv[0] is "token". Returns the exit status, after
/// it has printed an error in one line.
int token_command(int argc, char** argv);

}  // namespace feltwire
