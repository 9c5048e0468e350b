#pragma once
// Internal to server/control.

#include <string>

#include "server/control/control_service.hpp"

namespace feltwire {

/// "an observer"
std::string holder(Role role);

struct ControlService::PendingRequest {
  ControlPeer& peer;
  const Token& token;
  Answer answer;
};

}  // namespace feltwire
