#pragma once
// The connection to one viewer of a live picture.

#include <span>
#include <string>
#include <string_view>

#include "server/web/shared_bytes.hpp"
#include "server/web/websocket.hpp"

namespace feltwire::web {

class Viewer {
 public:
  /// [bytes] of answers and news that may wait for a viewer that does not read. A viewer with more
  /// is ended.
  static constexpr std::size_t kMostWaiting = std::size_t{64} * 1024;

  virtual ~Viewer() = default;
  /// An answer, or news: a text of this viewer only.
  virtual void send(const std::string& text) = 0;
  /// Data of the scene, which viewers share. They are no part of kMostWaiting, so call it only in a
  /// turn at whose begin the viewer was ready(): then it has the data of one turn at most.
  virtual void show_text(const SharedBytes& text) = 0;
  /// The message begins with bytes of this viewer only, `head`.
  virtual void show_binary(std::span<const std::uint8_t> head, const SharedBytes& data) = 0;
  void show_binary(const SharedBytes& data) { show_binary({}, data); }
  /// Asks the other end for a sign of life, which counts as a frame of it.
  virtual void ping() = 0;
  /// Whether all data were sent. A viewer that is not ready gets no picture.
  virtual bool ready() const = 0;
  /// The viewer may be gone when this returns.
  virtual void close(WebSocketClose code, std::string_view reason) = 0;
  /// Its token is valid: it may stay.
  virtual void admitted() = 0;
};

}  // namespace feltwire::web
