#include "sim/control_bridge.hpp"

#include <asio/buffer.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <exception>
#include <iostream>
#include <optional>

#include "protocol/control.hpp"

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
    self->requests();
    self->answers();
  });
}

/// Bytes as they are.
void ControlBridge::requests() {
  client_.async_read_some(
      asio::buffer(request_), [self = shared_from_this()](const Error& error, std::size_t size) {
        Error ignored;
        // The client asks no more; answers may still be on their way to it.
        if (error) return void(self->server_.shutdown(tcp::socket::shutdown_send, ignored));
        asio::async_write(self->server_, asio::buffer(self->request_, size),
                          [self](const Error& failed, std::size_t) {
                            if (failed) return self->close();
                            self->requests();
                          });
      });
}

/// Frame by frame.
void ControlBridge::answers() {
  asio::async_read(server_, asio::buffer(length_),
                   [self = shared_from_this()](const Error& error, std::size_t) {
                     const std::uint32_t size = control::frame_length(self->length_);
                     if (error || size == 0 || size > control::kMaxFrame) return self->close();
                     self->answer(size);
                   });
}

void ControlBridge::answer(std::size_t size) {
  body_.resize(size);
  asio::async_read(server_, asio::buffer(body_),
                   [self = shared_from_this()](const Error& error, std::size_t) {
                     if (error) return self->close();
                     std::optional<control::Message> message = control::decode(self->body_);
                     try {
                       if (message) {
                         if (auto* accepted = std::get_if<control::JoinAccepted>(&*message))
                           accepted->udp_port = self->map_(accepted->udp_port);
                         if (auto* list = std::get_if<control::SceneList>(&*message))
                           for (control::SceneEntry& scene : list->scenes)
                             scene.udp_port = self->map_(scene.udp_port);
                         return self->pass_on(control::encode(*message));
                       }
                     } catch (const std::exception& failed) {
                       std::cerr << "feltwire-lab: " << failed.what() << '\n';
                       return self->close();
                     }
                     // Whatever it is, it names no port.
                     std::vector<std::uint8_t> frame(self->length_.begin(), self->length_.end());
                     frame.insert(frame.end(), self->body_.begin(), self->body_.end());
                     self->pass_on(std::move(frame));
                   });
}

void ControlBridge::pass_on(std::vector<std::uint8_t> frame) {
  frame_ = std::move(frame);
  asio::async_write(client_, asio::buffer(frame_),
                    [self = shared_from_this()](const Error& error, std::size_t) {
                      if (error) return self->close();
                      self->answers();
                    });
}

void ControlBridge::close() {
  Error ignored;
  client_.close(ignored);
  server_.close(ignored);
}

}  // namespace feltwire
