#include "client/emulated_link/emulated_port.hpp"

#include "client/emulated_link/link_json.hpp"

namespace feltwire {

void EmulatedPort::send(Bytes datagram) noexcept {
  link_.up.enter(datagram, now_);
  send_due();
}

void EmulatedPort::send_due() noexcept {
  while (const auto datagram = link_.up.leave(now_)) line_->send(*datagram);
}

/// Returns why the link refuses these values, or nothing. Thread-safe, because it reads only
/// members that never change while the link is in use.
std::optional<std::string> EmulatedPort::refuses_link(const LinkQuality& link) const {
  for (const OneWayLink* way : {&link_.up, &link_.down})
    if (auto no = way->refuses(link)) return no;
  return std::nullopt;
}

void EmulatedPort::set_link(const LinkQuality& link) noexcept {
  link_.up.set(link);
  link_.down.set(link);
}

std::string EmulatedPort::report() const { return link_json(link_).dump(); }

void EmulatedPort::pass(Nanoseconds now) noexcept {
  now_ = now;
  send_due();
  for (int i = 0; i < kBurst; ++i) {
    const auto datagram = line_->receive();
    if (!datagram) return;
    link_.down.enter(*datagram, now_);
  }
}

}  // namespace feltwire
