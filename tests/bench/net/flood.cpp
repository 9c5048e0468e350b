#include "tests/bench/net/flood.hpp"

#include "tests/support/garbage.hpp"

namespace feltwire::netbench {

Flood::Flood(std::uint16_t port, const std::vector<std::uint64_t>& sessions) {
  socket_.connect(port);
  test::Garbage garbage(sessions);
  for (std::size_t i = 0; i < kDatagrams; ++i) {
    datagrams_.push_back(garbage.next());
    parts_[i] = {datagrams_[i].data(), datagrams_[i].size()};
    messages_[i].msg_hdr.msg_iov = &parts_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
  }
}

void Flood::burst() noexcept {
  const int sent = ::sendmmsg(socket_.file(), messages_.data() + next_, kBurst, MSG_DONTWAIT);
  if (sent > 0) sent_ += static_cast<std::uint64_t>(sent);
  next_ = (next_ + kBurst) % kDatagrams;
}

}  // namespace feltwire::netbench
