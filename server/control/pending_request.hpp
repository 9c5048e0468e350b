#pragma once
// A request with its sender.

#include <functional>

#include "protocol/wire/control.hpp"
#include "server/access/tokens.hpp"
#include "server/control/control_endpoint.hpp"

namespace feltwire {

using ControlAnswer = std::function<void(control::Message)>;

struct PendingRequest {
  ControlPeer& peer;
  const Token& token;  // of the sender; do not keep it
  ControlAnswer answer;
};

}  // namespace feltwire
