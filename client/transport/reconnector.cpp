#include "client/transport/reconnector.hpp"

#include <algorithm>
#include <utility>

#include "protocol/session/grant.hpp"

namespace feltwire {

Reconnector::Attempt Reconnector::attempt(FleetRoute& route, const control::JoinRequest& request,
                                          const RejoinOptions& options) {
  try {
    const Joined joined = route.join(request, options.timeout);
    const ServerAccess& server = joined.host;
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

Reconnector::Reconnector(FleetRoute route, control::JoinRequest request, Ring<SessionAddress>& out,
                         const RejoinOptions& options)
    : route_(std::move(route)),
      request_(std::move(request)),
      out_(out),
      options_(options),
      backoff_(options.first_wait, options.longest_wait, options.seed) {}

void Reconnector::look(bool connected, Clock::time_point now) noexcept {
  if (attempt_.valid()) {
    if (!attempt_.is_ready()) return;
    Attempt done = outcome();
    if (done.route) route_ = *std::move(done.route);
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
    next_ = now + backoff_.next();
    return;
  }
  if (connected) {
    handed_over_ = false;
    lost_ = false;
    backoff_.reset();
    return;
  }
  if (!std::exchange(lost_, true)) next_ = std::max(next_, now + backoff_.next());
  if (now < next_ || !refusal_.empty()) return;
  // The new session may not have answered yet, so wait before the next attempt.
  if (handed_over_ && now < handed_over_at_ + options_.longest_wait) return;
  ++attempts_;
  try {
    begin();
  } catch (const std::exception&) {  // missing memory or thread counts as a failed attempt
    attempt_ = {};
    next_ = now + backoff_.next();
  }
}

void Reconnector::begin() {
  attempt_ =
      BackgroundWork<Attempt>([route = route_, request = request_, options = options_]() mutable {
        Attempt done = attempt(route, request, options);
        done.route = std::move(route);
        return done;
      });
}

}  // namespace feltwire
