#pragma once
// A port with an emulated link in front of it. Every datagram of both directions passes the link.

#include <memory>
#include <utility>

#include "client/emulated_link/link.hpp"
#include "client/transport/datagram_port.hpp"

namespace feltwire {

class EmulatedPort final : public DatagramPort {
 public:
  /// `line`: never null. The emulator's clock begins at 0; pass() sets it.
  EmulatedPort(std::unique_ptr<DatagramPort> line, TwoWayLink link)
      : line_(std::move(line)), link_(std::move(link)) {}

  const TwoWayLink& link() const { return link_; }

  bool connect(const Address& server) noexcept override { return line_->connect(server); }
  bool reroute() noexcept override { return line_->reroute(); }
  void send(Bytes datagram) noexcept override;
  void send_now(Bytes datagram) noexcept override { line_->send_now(datagram); }
  std::optional<Bytes> receive() noexcept override { return link_.down.leave(now_); }
  bool delays() const noexcept override { return true; }
  void pass(Nanoseconds now) noexcept override;
  std::optional<Nanoseconds> next_due() const noexcept override { return link_.next_due(); }
  bool emulates() const noexcept override { return true; }
  std::optional<std::string> refuses_link(const LinkQuality& link) const override;
  void set_link(const LinkQuality& link) noexcept override;
  int descriptor() const noexcept override { return line_->descriptor(); }
  PortStatistics statistics() const noexcept override { return line_->statistics(); }
  std::string report() const override;

 private:
  void send_due() noexcept;

  std::unique_ptr<DatagramPort> line_;
  TwoWayLink link_;
  Nanoseconds now_{0};
};

}  // namespace feltwire
