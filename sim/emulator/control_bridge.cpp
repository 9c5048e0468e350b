#include "sim/emulator/control_bridge.hpp"

#include <asio/buffer.hpp>
#include <asio/write.hpp>
#include <iostream>

namespace feltwire {

using asio::ip::tcp;
using Error = std::error_code;

void ControlBridge::start(const tcp::endpoint& server) {
  server_.async_connect(server, [self = shared_from_this(), server](const Error& error) {
    if (error) {
      std::cerr << "feltwire-lab: cannot connect to " << server << ": " << error.message()
                << "; is feltwire-server running there?\n";
      return self->close();
    }
    Error ignored;
    for (tcp::socket* socket : {&self->client_, &self->server_})
      socket->set_option(tcp::no_delay(true), ignored);
    self->pass_on(self->client_, self->server_, self->up_);
    self->pass_on(self->server_, self->client_, self->down_);
  });
}

void ControlBridge::pass_on(tcp::socket& from, tcp::socket& to, Buffer& buffer) {
  from.async_read_some(asio::buffer(buffer), [self = shared_from_this(), &from, &to, &buffer](
                                                 const Error& error, std::size_t size) {
    if (error == asio::error::eof) {
      // The peer of `from` has ended its stream. The peer of `to` may still send.
      Error ignored;
      return void(to.shutdown(tcp::socket::shutdown_send, ignored));
    }
    if (error) return self->close();
    asio::async_write(to, asio::buffer(buffer, size),
                      [self, &from, &to, &buffer](const Error& failed, std::size_t) {
                        if (failed) return self->close();
                        self->pass_on(from, to, buffer);
                      });
  });
}

void ControlBridge::close() {
  Error ignored;
  client_.close(ignored);
  server_.close(ignored);
}

}  // namespace feltwire
