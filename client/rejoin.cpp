#include "client/rejoin.hpp"

#include <algorithm>
#include <future>
#include <thread>
#include <utility>

namespace feltwire {
namespace {

std::optional<SessionAddress> attempt(const ServerAccess& server,
                                      const control::JoinRequest& request,
                                      std::chrono::milliseconds timeout) {
  try {
    const Joined joined = join(server, request, timeout);
    // The servo's bound stands on these.
    if (!(joined.accepted.parameters == request.parameters)) return std::nullopt;
    return SessionAddress{joined.datagrams, joined.accepted.session, joined.keys};
  } catch (const SessionError&) {
    return std::nullopt;  // not there yet, or full: the next attempt may do better
  }
}

}  // namespace

Rejoiner::Rejoiner(ServerAccess server, control::JoinRequest request, Ring<SessionAddress>& out,
                   const RejoinOptions& options)
    : server_(std::move(server)),
      request_(std::move(request)),
      out_(out),
      options_(options),
      wait_(options.first_wait) {}

void Rejoiner::look(bool connected, Clock::time_point now) {
  if (attempt_.valid()) {
    if (attempt_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    const std::optional<SessionAddress> session = attempt_.get();
    // Also when the old session answers again meanwhile: two would stand at the server else.
    handed_over_ = session && out_.push(*session);
    handed_over_at_ = now;
    next_ = now + wait_;
    wait_ = std::min(2 * wait_, options_.longest_wait);
    return;
  }
  if (connected) {
    handed_over_ = false;
    wait_ = options_.first_wait;
    return;
  }
  if (now < next_) return;
  // What was handed over may be lost again before it ever answered.
  if (handed_over_ && now < handed_over_at_ + options_.longest_wait) return;
  ++attempts_;
  std::packaged_task<std::optional<SessionAddress>()> task(
      [server = server_, request = request_, timeout = options_.timeout] {
        return attempt(server, request, timeout);
      });
  attempt_ = task.get_future();
  // On its own, with nothing of ours: the system may look for a name that is gone for many seconds,
  // and whoever is told to end meanwhile does not wait for that.
  std::thread(std::move(task)).detach();
}

}  // namespace feltwire
