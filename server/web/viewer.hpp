#pragma once
// The connection to one viewer of a live picture.

#include <string>
#include <string_view>

#include "server/web/messages.hpp"
#include "server/web/websocket.hpp"

namespace feltwire::web {

class Viewer {
 public:
  virtual ~Viewer() = default;
  virtual void send(const std::string& text) = 0;
  virtual void send(const Bytes& binary) = 0;
  /// Whether all data were sent. A viewer that is not ready gets no picture.
  virtual bool ready() const = 0;
  /// The viewer may be gone when this returns.
  virtual void close(WebSocketClose code, std::string_view reason) = 0;
  /// Its token is valid: it may stay.
  virtual void admitted() = 0;
};

}  // namespace feltwire::web
