// The actions of an admin on the page: changes, evictions, reloads. Each is handled like the
// same request at the control port.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <charconv>
#include <stdexcept>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/post.hpp"
#include "server/web/viewer_message.hpp"
#include "server/web/viewer_slot.hpp"

namespace feltwire::web {
namespace {

std::string who(const Token& token) {
  return visible("client " + token.client + " (token " + token.id + ", live page)");
}

/// The id of a session, from its digits; 0 if they are no number.
std::uint64_t session_id(std::string_view digits) {
  std::uint64_t id = 0;
  const char* end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, id);
  return read.ec == std::errc() && read.ptr == end ? id : 0;
}

}  // namespace

/// The token by which the viewer is an admin of the scene that it watches; null: no admin.
const Token* ViewerHub::admin_of(const ViewerSlot& slot) const {
  for (const std::string* id : {&slot.token, &slot.admin}) {
    const Token* token = find_token(tokens_.tokens(), *id);
    if (token != nullptr && slot.stage != nullptr && !expired(*token, calendar_now()) &&
        covers(token->role, Role::admin) && opens(*token, slot.stage->scene->name()))
      return token;
  }
  return nullptr;
}

/// Does what an admin asks; false if the message asks for nothing of that kind.
bool ViewerHub::act(ViewerSlot& slot, const ViewerMessage& message) {
  if (!message.admin && !message.set && !message.evict && !message.reload && !message.record)
    return false;
  if (only_shown(slot)) return true;
  if (message.admin) {
    become_admin(slot, *message.admin);
    return true;
  }
  refresh_tokens();
  const Token* admin = admin_of(slot);
  if (admin == nullptr) {
    slot.viewer->send(refused("this is for admins of the scene; enter the token of one"));
  } else if (!changes_.take(admin->client, monotonic_now())) {
    slot.viewer->send(
        refused("client '" + admin->client + "' changes too much at once; wait a moment"));
  } else if (message.set) {
    set(slot, *message.set);
  } else if (message.evict) {
    evict(slot, *message.evict);
  } else if (message.record) {
    write_flight(slot);
  } else {
    reload(slot);
  }
  return true;
}

void ViewerHub::become_admin(ViewerSlot& slot, std::string_view text) {
  const Token* token = good_token(text);
  if (token == nullptr) {
    if (may_try_again(slot)) slot.viewer->send(refused(kNoGoodToken));
    return;
  }
  slot.admin = token->id;
  if (admin_of(slot) == nullptr) {
    slot.admin.clear();
    return slot.viewer->send(refused("the token is not of an admin of this scene; its role is " +
                                     std::string(name(token->role))));
  }
  slot.viewer->send(admin_text());
}

/// Refuses every viewer's request on a page that only shows a remote server. True: refused.
bool ViewerHub::only_shown(const ViewerSlot& slot) {
  if (slot.stage == nullptr || slot.stage->scene->controls() != nullptr) return false;
  slot.viewer->send(
      refused("this page only looks on at the server; change the scene on the page of the server "
              "itself, or "
              "with feltwire-client admin"));
  return true;
}

void ViewerHub::set(ViewerSlot& slot, const ViewerSet& wanted) {
  if (wanted.gravity) return change(slot, GravityChange{*wanted.gravity});
  if (wanted.session.empty()) return change(slot, wanted.material);
  const std::uint64_t id = session_id(wanted.session);
  const auto& hands = slot.stage->hands;
  const auto hand = std::ranges::find(hands, id, &HandDescription::session);
  if (hand == hands.end())
    return slot.viewer->send(refused("there is no session " + wanted.session + " here"));
  if (wanted.link) return change(slot, LinkChange{id, *wanted.link});
  if (wanted.lead_share) return change(slot, LeadChange{id, *wanted.lead_share});
  try {
    change(slot, ParameterChange{
                     id, with_words(hand->parameters.value_or(SessionParameters{}), wanted.bound)});
  } catch (const std::invalid_argument& error) {
    slot.viewer->send(refused(error.what()));
  }
}

/// Makes the change in the scene's thread. A viewer that has left meanwhile gets no answer.
void ViewerHub::change(ViewerSlot& slot, LiveChange change) {
  const std::string by = who(*admin_of(slot)), scene = slot.stage->scene->name();
  const auto* law = std::get_if<ParameterChange>(&change);
  // The next change builds on this one even before the scene's thread describes the session.
  std::optional<ParameterChange> made;
  if (law != nullptr && law->parameters.side == BoundingSide::server) made = *law;
  slot.stage->scene->controls()->change(
      std::move(change), post_to(io_),
      [this, by, scene, id = slot.id, stage = slot.stage, made = std::move(made),
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
        if (const auto asker = slots_.find(id); asker != slots_.end())
          asker->second.viewer->send(no != nullptr ? refused(no->reason)
                                                   : changed_text(std::get<std::string>(outcome)));
      });
}

void ViewerHub::evict(ViewerSlot& slot, const std::string& session) {
  const std::uint64_t id = session_id(session);
  const auto& hands = slot.stage->hands;
  if (std::ranges::find(hands, id, &HandDescription::session) == hands.end())
    return slot.viewer->send(refused("there is no session " + session + " here"));
  slot.stage->scene->controls()->evict(id);
  spdlog::info("scene {}: session {} was evicted by {}", visible(slot.stage->scene->name()), id,
               who(*admin_of(slot)));
  slot.viewer->send(changed_text("the session is evicted"));
}

void ViewerHub::reload(ViewerSlot& slot) {
  if (!reload_)
    return slot.viewer->send(
        refused("the scenes of this server do not come from files, so they cannot be reloaded"));
  const auto stage = std::ranges::find(stages_, slot.stage, &std::unique_ptr<Stage>::get);
  spdlog::info("scene {} is reloaded by {}", visible(slot.stage->scene->name()),
               who(*admin_of(slot)));
  reload_(static_cast<std::size_t>(stage - stages_.begin()));
}

/// Asks for a flight record. A viewer that has left meanwhile gets no answer.
void ViewerHub::write_flight(ViewerSlot& slot) {
  if (!write_flight_)
    return slot.viewer->send(
        refused("this server keeps no flight record; start it with --flight-recorder DIR"));
  const auto stage = std::ranges::find(stages_, slot.stage, &std::unique_ptr<Stage>::get);
  spdlog::info("scene {}: {} asks for a flight record", visible(slot.stage->scene->name()),
               who(*admin_of(slot)));
  write_flight_(
      static_cast<std::size_t>(stage - stages_.begin()),
      [this, id = slot.id,
       alive = std::weak_ptr(alive_)](std::variant<std::string, control::Refused> outcome) {
        asio::post(io_, [this, id, alive, outcome = std::move(outcome)] {
          if (alive.expired()) return;
          const auto asker = slots_.find(id);
          if (asker == slots_.end()) return;
          const auto* no = std::get_if<control::Refused>(&outcome);
          asker->second.viewer->send(
              no != nullptr ? refused(no->reason)
                            : changed_text("flight record: " + std::get<std::string>(outcome)));
        });
      });
}

void ViewerHub::tell(std::size_t scene, const std::optional<std::string>& wrong) {
  const Stage* stage = stages_.at(scene).get();
  const std::string line =
      wrong ? log_text("error", *wrong)
            : log_text("info", "Scene " + stage->scene->name() + " was reloaded from its file.");
  for (const auto& [id, slot] : slots_)
    if (slot.stage == stage && !slot.foxglove && (!wrong || admin_of(slot) != nullptr))
      slot.viewer->send(line);
}

}  // namespace feltwire::web
