#pragma once
// The options of feltwire-view: command line and environment.

#include "gateway/app/gateway.hpp"

namespace feltwire {

/// Ends the program after --help. Throws std::invalid_argument, one line.
GatewayConfig gateway_config(int argc, char** argv);

}  // namespace feltwire
