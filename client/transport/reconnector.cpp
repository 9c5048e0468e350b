#include "client/transport/reconnector.hpp"

#include <algorithm>
#include <utility>

#include "protocol/session/grant.hpp"

namespace feltwire {

Reconnector::Attempt Reconnector::attempt(const ServerAccess& server,
                                          const control::JoinRequest& request,
                                          const RejoinOptions& options) {
  try {
    const Joined joined = join(server, request, options.timeout);
    if (!options.seats.empty() && joined.accepted.seats != options.seats)
      return {std::nullopt, to_string(server.endpoint) +
                                " now has other seats for robots than those of the session before; "
                                "start anew"};
    // The servo loop does not change its parameters, so a new session must have equal parameters.
    const auto changed = difference(request.parameters, joined.accepted.parameters);
    if (!changed)
      return {SessionAddress{joined.datagrams, joined.accepted.session, joined.keys}, {}};
    return {std::nullopt, to_string(server.endpoint) +
                              " now grants other parameters than those of the session before (" +
                              *changed + "); start anew"};
  } catch (const LastingError& error) {
    return {std::nullopt, error.what()};
  } catch (const std::exception&) {  // the next attempt may have the resources
    return {};
  }
}

/// Returns the result of the finished attempt. An exception counts as a failed attempt.
Reconnector::Attempt Reconnector::outcome() noexcept {
  try {
    return attempt_.get();
  } catch (const std::exception&) {
    return {};
  } catch (const Cancelled&) {  // the process ends
    return {};
  }
}

Reconnector::Reconnector(ServerAccess server, control::JoinRequest request,
                         Ring<SessionAddress>& out, const RejoinOptions& options)
    : server_(std::move(server)),
      request_(std::move(request)),
      out_(out),
      options_(options),
      wait_(options.first_wait) {}

void Reconnector::look(bool connected, Clock::time_point now) noexcept {
  if (attempt_.valid()) {
    if (!attempt_.is_ready()) return;
    Attempt done = outcome();
    if (std::exchange(outdated_, false)) done = {};
    // The old session continues if it answers again, so ignore the refusal in this case.
    if (!connected) refusal_ = std::move(done.refusal);
    // Use the new session even if the old one answers again. Otherwise the server would keep two
    // sessions.
    handed_over_ = done.session && out_.push(*done.session);
    if (handed_over_) {
      ++sessions_;
      session_ = done.session->session;
    }
    handed_over_at_ = now;
    put_off(now);
    return;
  }
  if (connected) {
    handed_over_ = false;
    wait_ = options_.first_wait;
    return;
  }
  if (now < next_ || !refusal_.empty()) return;
  // The new session may not have answered yet, so wait before the next attempt.
  if (handed_over_ && now < handed_over_at_ + options_.longest_wait) return;
  ++attempts_;
  try {
    begin();
  } catch (const std::exception&) {  // missing memory or thread counts as a failed attempt
    attempt_ = {};
    put_off(now);
  }
}

void Reconnector::put_off(Clock::time_point now) noexcept {
  next_ = now + wait_;
  wait_ = std::min(2 * wait_, options_.longest_wait);
}

void Reconnector::begin() {
  attempt_ = BackgroundWork<Attempt>([server = server_, request = request_, options = options_] {
    return attempt(server, request, options);
  });
}

}  // namespace feltwire
