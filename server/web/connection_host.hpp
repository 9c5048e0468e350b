#pragma once
// The server behind a connection to the live page's port, as the connection needs it.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <chrono>
#include <string_view>

#include "server/access/connection_slots.hpp"
#include "server/web/http_responses.hpp"
#include "server/web/viewer_hub.hpp"

namespace feltwire::web {

class ConnectionHost {
 public:
  virtual asio::io_context& io() = 0;
  virtual ViewerHub& hub() = 0;
  /// The name of the port, for the log.
  virtual std::string_view log_name() const = 0;
  /// The site for a request from this address.
  virtual Site site(const asio::ip::address& asked_from) = 0;
  /// From connecting to a whole request, and from there to a valid token.
  virtual std::chrono::milliseconds patience() const = 0;
  /// The connection has shown a valid token: no stranger may take its place.
  virtual void admitted(ConnectionSlots::Id id) = 0;
  /// It is closing: it needs none of the places for those with a token any more.
  virtual void parting(ConnectionSlots::Id id) = 0;
  /// It has ended: forget it.
  virtual void ended(ConnectionSlots::Id id) noexcept = 0;

 protected:
  ~ConnectionHost() = default;
};

}  // namespace feltwire::web
