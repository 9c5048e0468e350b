// The actions of an admin on the page: changes, evictions, reloads. Each takes the way of the same
// request at the control port.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <charconv>
#include <stdexcept>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "server/web/seat.hpp"
#include "server/web/viewer_message.hpp"

namespace feltwire::web {
namespace {

std::string who(const Token& token) {
  return visible("client " + token.client + " (token " + token.id + ", live page)");
}

/// The id of a session, from its digits; 0 where they are none.
std::uint64_t session_id(std::string_view digits) {
  std::uint64_t id = 0;
  const char* end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, id);
  return read.ec == std::errc() && read.ptr == end ? id : 0;
}

}  // namespace

/// The token by which the viewer is an admin of the scene that it watches; null: it is none.
const Token* Audience::admin_of(const Seat& seat) const {
  for (const std::string* id : {&seat.token, &seat.admin}) {
    const Token* token = find_token(tokens_.tokens(), *id);
    if (token != nullptr && seat.stage != nullptr && !expired(*token, calendar_now()) &&
        covers(token->role, Role::admin) && opens(*token, seat.stage->scene->name()))
      return token;
  }
  return nullptr;
}

/// Does what is an admin's to ask; false where the message asks nothing of that kind.
bool Audience::act(Seat& seat, const ViewerMessage& message) {
  if (!message.admin && !message.set && !message.evict && !message.reload && !message.record)
    return false;
  if (only_shown(seat)) return true;
  if (message.admin) {
    become_admin(seat, *message.admin);
    return true;
  }
  refresh_tokens();
  const Token* admin = admin_of(seat);
  if (admin == nullptr) {
    seat.viewer->send(refused("this is for admins of the scene; enter the token of one"));
  } else if (!changes_.take(admin->client, monotonic_now())) {
    seat.viewer->send(
        refused("client '" + admin->client + "' changes too much at once; wait a moment"));
  } else if (message.set) {
    set(seat, *message.set);
  } else if (message.evict) {
    evict(seat, *message.evict);
  } else if (message.record) {
    write_flight(seat);
  } else {
    reload(seat);
  }
  return true;
}

void Audience::become_admin(Seat& seat, std::string_view text) {
  const Token* token = good_token(text);
  if (token == nullptr) {
    if (may_try_again(seat)) seat.viewer->send(refused(kNoGoodToken));
    return;
  }
  seat.admin = token->id;
  if (admin_of(seat) == nullptr) {
    seat.admin.clear();
    return seat.viewer->send(refused("the token is not of an admin of this scene; its role is " +
                                     std::string(name(token->role))));
  }
  seat.viewer->send(admin_text());
}

/// The same for all who ask: whoever they are, nothing can be done here.
bool Audience::only_shown(const Seat& seat) {
  if (seat.stage == nullptr || seat.stage->scene->controls() != nullptr) return false;
  seat.viewer->send(
      refused("this page only looks on at the server; change the scene on the page of the server "
              "itself, or "
              "with feltwire-client admin"));
  return true;
}

void Audience::set(Seat& seat, const ViewerSet& wanted) {
  if (wanted.gravity) return change(seat, GravityChange{*wanted.gravity});
  if (wanted.session.empty()) return change(seat, wanted.material);
  const std::uint64_t id = session_id(wanted.session);
  const auto& hands = seat.stage->hands;
  const auto hand = std::ranges::find(hands, id, &HandDescription::session);
  if (hand == hands.end())
    return seat.viewer->send(refused("there is no session " + wanted.session + " here"));
  if (wanted.link) return change(seat, LinkChange{id, *wanted.link});
  if (wanted.lead_share) return change(seat, LeadChange{id, *wanted.lead_share});
  try {
    change(seat, ParameterChange{
                     id, with_words(hand->parameters.value_or(SessionParameters{}), wanted.bound)});
  } catch (const std::invalid_argument& error) {
    seat.viewer->send(refused(error.what()));
  }
}

/// In the scene's thread. A viewer that has left meanwhile hears nothing of it.
void Audience::change(Seat& seat, LiveChange change) {
  const std::string by = who(*admin_of(seat)), scene = seat.stage->scene->name();
  const auto* law = std::get_if<ParameterChange>(&change);
  // The next change begins from this one, also before the scene's thread describes the session.
  std::optional<ParameterChange> made;
  if (law != nullptr && law->parameters.side == BoundingSide::server) made = *law;
  seat.stage->scene->controls()->change(
      std::move(change), io_,
      [this, by, scene, id = seat.id, stage = seat.stage, made = std::move(made),
       alive = std::weak_ptr(alive_)](std::variant<std::string, control::Refused> outcome) {
        const auto* no = std::get_if<control::Refused>(&outcome);
        if (no == nullptr)
          spdlog::info("scene {}: changed by {}: {}", visible(scene), by,
                       visible(std::get<std::string>(outcome)));
        if (alive.expired()) return;
        if (no == nullptr && made) {
          const auto hand =
              std::ranges::find(stage->hands, made->session, &HandDescription::session);
          if (hand != stage->hands.end()) hand->parameters = made->parameters;
        }
        if (const auto asker = seats_.find(id); asker != seats_.end())
          asker->second.viewer->send(no != nullptr ? refused(no->reason)
                                                   : changed_text(std::get<std::string>(outcome)));
      });
}

void Audience::evict(Seat& seat, const std::string& session) {
  const std::uint64_t id = session_id(session);
  const auto& hands = seat.stage->hands;
  if (std::ranges::find(hands, id, &HandDescription::session) == hands.end())
    return seat.viewer->send(refused("there is no session " + session + " here"));
  seat.stage->scene->controls()->evict(id);
  spdlog::info("scene {}: session {} was evicted by {}", visible(seat.stage->scene->name()), id,
               who(*admin_of(seat)));
  seat.viewer->send(changed_text("the session is evicted"));
}

void Audience::reload(Seat& seat) {
  if (!reload_)
    return seat.viewer->send(
        refused("the scenes of this server do not come from files, so they cannot be reloaded"));
  const auto stage = std::ranges::find(stages_, seat.stage, &std::unique_ptr<Stage>::get);
  spdlog::info("scene {} is reloaded by {}", visible(seat.stage->scene->name()),
               who(*admin_of(seat)));
  reload_(static_cast<std::size_t>(stage - stages_.begin()));
}

/// A viewer that has left meanwhile hears nothing of it.
void Audience::write_flight(Seat& seat) {
  if (!write_flight_)
    return seat.viewer->send(
        refused("this server keeps no flight record; start it with --flight-recorder DIR"));
  const auto stage = std::ranges::find(stages_, seat.stage, &std::unique_ptr<Stage>::get);
  spdlog::info("scene {}: {} asks for a flight record", visible(seat.stage->scene->name()),
               who(*admin_of(seat)));
  write_flight_(
      static_cast<std::size_t>(stage - stages_.begin()),
      [this, id = seat.id,
       alive = std::weak_ptr(alive_)](std::variant<std::string, control::Refused> outcome) {
        asio::post(io_, [this, id, alive, outcome = std::move(outcome)] {
          if (alive.expired()) return;
          const auto asker = seats_.find(id);
          if (asker == seats_.end()) return;
          const auto* no = std::get_if<control::Refused>(&outcome);
          asker->second.viewer->send(
              no != nullptr ? refused(no->reason)
                            : changed_text("flight record: " + std::get<std::string>(outcome)));
        });
      });
}

void Audience::tell(std::size_t scene, const std::optional<std::string>& wrong) {
  const Stage* stage = stages_.at(scene).get();
  const std::string line =
      wrong ? log_text("error", *wrong)
            : log_text("info", "Scene " + stage->scene->name() + " was reloaded from its file.");
  for (const auto& [id, seat] : seats_)
    if (seat.stage == stage && !seat.foxglove && (!wrong || admin_of(seat) != nullptr))
      seat.viewer->send(line);
}

}  // namespace feltwire::web
