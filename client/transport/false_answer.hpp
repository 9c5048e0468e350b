#pragma once

#include "client/transport/control_client.hpp"

namespace feltwire {

/// The server's answers contradict each other, or are more than a client takes: it lies, or is none
/// of this protocol.
class FalseAnswer : public LastingError {
 public:
  using LastingError::LastingError;
};

}  // namespace feltwire
