#pragma once
// The way to one viewer of a live picture.

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
  /// Whether all that was sent has left. Who is not ready is shown no picture.
  virtual bool ready() const = 0;
  /// It may be gone when this returns.
  virtual void close(WebSocketClose code, std::string_view reason) = 0;
  /// Its token is good: it may stay.
  virtual void admitted() = 0;
};

}  // namespace feltwire::web
