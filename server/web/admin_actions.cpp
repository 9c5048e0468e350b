#include "server/web/admin_actions.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <charconv>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/post.hpp"
#include "server/web/page_messages.hpp"
#include "server/web/viewed_scene.hpp"

namespace feltwire::web {
namespace {

constexpr const char* kNoRecordings =
    "admins start no recordings at this server; start it with --recordings DIR";

/// Returns the session id that the decimal digits give; 0 if the text is no number.
std::uint64_t session_id(std::string_view digits) {
  std::uint64_t id = 0;
  const char* end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, id);
  return read.ec == std::errc() && read.ptr == end ? id : 0;
}

/// Refuses the request if the page only shows the scene of a remote server. Returns whether it was
/// refused.
bool refuse_as_observer(const ViewerSlot& slot) {
  if (slot.scene == nullptr || slot.scene->source().controls() != nullptr) return false;
  slot.viewer->send(
      refused("this page only looks on at the server; change the scene on the page of the server "
              "itself, or "
              "with feltwire-client admin"));
  return true;
}

}  // namespace

AdminActions::AdminActions(asio::io_context& io, ViewerTokens& tokens, ViewTickets& tickets,
                           ViewerSlots& viewers, Callbacks callbacks)
    : io_(io),
      tokens_(tokens),
      tickets_(tickets),
      viewers_(viewers),
      callbacks_(std::move(callbacks)) {}

/// Returns the token that makes the viewer an admin of the scene that it watches; null if there is
/// none.
const Token* AdminActions::admin_token(const ViewerSlot& slot) const {
  for (const std::string* id : {&slot.token, &slot.admin}) {
    const Token* token = tokens_.find(*id);
    if (token != nullptr && slot.scene != nullptr && !expired(*token, calendar_now()) &&
        covers(token->role, Role::admin) && opens(*token, slot.scene->name()))
      return token;
  }
  return nullptr;
}

AdminActions::Outcome AdminActions::handle(ViewerSlot& slot, const ViewerMessage& message) {
  if (!message.admin && !message.set && !message.evict && !message.reload && !message.record &&
      !message.recording && !message.download)
    return Outcome::not_asked;
  if (refuse_as_observer(slot)) return Outcome::handled;
  tokens_.refresh();
  if (message.admin) return become_admin(slot, *message.admin);
  const Token* admin = admin_token(slot);
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
  } else if (message.recording) {
    record(slot, *message.recording);
  } else if (message.download) {
    give_download(slot, *message.download);
  } else {
    reload(slot);
  }
  return Outcome::handled;
}

AdminActions::Outcome AdminActions::become_admin(ViewerSlot& slot, std::string_view text) {
  const Token* token = tokens_.authenticate(text);
  if (token == nullptr) return Outcome::wrong_token;
  slot.admin = token->id;
  if (is_admin(slot)) {
    slot.viewer->send(admin_text());
  } else {
    slot.admin.clear();
    slot.viewer->send(refused("the token is not of an admin of this scene; its role is " +
                              std::string(name(token->role))));
  }
  return Outcome::handled;
}

/// Returns the client name and the token id of the admin, for the log. Precondition:
/// is_admin(slot).
std::string AdminActions::author(const ViewerSlot& slot) const {
  const Token& token = *admin_token(slot);
  return visible("client " + token.client + " (token " + token.id + ", live page)");
}

/// Sends an answer to the viewer, unless the viewer has left.
void AdminActions::answer(ViewerId id, const std::string& text) {
  if (const auto asker = viewers_.find(id); asker != viewers_.end())
    asker->second.viewer->send(text);
}

void AdminActions::set(ViewerSlot& slot, const ViewerSet& wanted) {
  if (wanted.gravity) return change(slot, GravityChange{*wanted.gravity});
  if (wanted.session.empty()) return change(slot, wanted.material);
  const std::uint64_t id = session_id(wanted.session);
  const auto& hands = slot.scene->hands();
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

/// Sends the change to the scene's thread, and answers the viewer after the change.
void AdminActions::change(ViewerSlot& slot, LiveChange change) {
  const auto* law = std::get_if<ParameterChange>(&change);
  // Store the new parameters in the viewer's list of hands: the next change starts from them,
  // perhaps before the scene describes its hands again.
  std::optional<ParameterChange> made;
  if (law != nullptr && law->parameters.side == BoundingSide::server) made = *law;
  slot.scene->source().controls()->change(
      std::move(change), post_to(io_),
      [this, by = author(slot), name = slot.scene->name(), id = slot.id, scene = slot.scene,
       made = std::move(made),
       alive = std::weak_ptr(alive_)](std::variant<std::string, control::Refused> outcome) {
        const auto* no = std::get_if<control::Refused>(&outcome);
        if (no == nullptr)
          spdlog::info("scene {}: changed by {}: {}", visible(name), by,
                       visible(std::get<std::string>(outcome)));
        if (alive.expired()) return;
        if (no == nullptr && made) {
          auto& hands = scene->hands();
          const auto hand = std::ranges::find(hands, made->session, &HandDescription::session);
          if (hand != hands.end()) hand->parameters = made->parameters;
        }
        answer(id,
               no != nullptr ? refused(no->reason) : changed_text(std::get<std::string>(outcome)));
      });
}

void AdminActions::evict(ViewerSlot& slot, const std::string& session) {
  const std::uint64_t id = session_id(session);
  const auto& hands = slot.scene->hands();
  if (std::ranges::find(hands, id, &HandDescription::session) == hands.end())
    return slot.viewer->send(refused("there is no session " + session + " here"));
  slot.scene->source().controls()->evict(id);
  spdlog::info("scene {}: session {} was evicted by {}", visible(slot.scene->name()), id,
               author(slot));
  slot.viewer->send(changed_text("the session is evicted"));
}

void AdminActions::reload(ViewerSlot& slot) {
  if (!callbacks_.reload)
    return slot.viewer->send(
        refused("the scenes of this server do not come from files, so they cannot be reloaded"));
  spdlog::info("scene {} is reloaded by {}", visible(slot.scene->name()), author(slot));
  callbacks_.reload(slot.scene->index());
}

void AdminActions::write_flight(ViewerSlot& slot) {
  if (!callbacks_.write_flight)
    return slot.viewer->send(
        refused("this server keeps no flight record; start it with --flight-recorder DIR"));
  spdlog::info("scene {}: {} asks for a flight record", visible(slot.scene->name()), author(slot));
  callbacks_.write_flight(
      slot.scene->index(), [this, id = slot.id, alive = std::weak_ptr(alive_)](
                               std::variant<std::string, control::Refused> outcome) {
        asio::post(io_, [this, id, alive, outcome = std::move(outcome)] {
          if (alive.expired()) return;
          const auto* no = std::get_if<control::Refused>(&outcome);
          answer(id, no != nullptr
                         ? refused(no->reason)
                         : changed_text("flight record: " + std::get<std::string>(outcome)));
        });
      });
}

/// Asks the recorder, and calls `take` with its answer on the page's thread.
template <class Take>
void AdminActions::ask_recorder(std::size_t scene, control::RecordingAction action, Take take) {
  callbacks_.record(
      scene, action,
      [this, take = std::move(take), alive = std::weak_ptr(alive_)](Recordings outcome) {
        asio::post(io_, [take, alive, outcome = std::move(outcome)] {
          if (!alive.expired()) take(outcome);
        });
      });
}

/// Sends the recordings of a scene to its admins, unless they have this text already.
void AdminActions::show(std::size_t scene, const control::SceneRecordings& recordings) {
  const std::string text = recordings_text(recordings);
  for (auto& [id, slot] : viewers_) {
    if (slot.foxglove || !is_admin(slot) || slot.scene->index() != scene || slot.recordings == text)
      continue;
    slot.recordings = text;
    slot.viewer->send(text);
  }
}

void AdminActions::look_after(Nanoseconds now) {
  constexpr Nanoseconds kBetweenLooks = std::chrono::seconds(1);
  if (!callbacks_.record || now - looked_ < kBetweenLooks) return;
  looked_ = now;
  std::set<std::size_t> scenes;
  for (const auto& [id, slot] : viewers_)
    if (!slot.foxglove && is_admin(slot)) scenes.insert(slot.scene->index());
  for (const std::size_t scene : scenes)
    ask_recorder(scene, control::RecordingAction::look, [this, scene](const Recordings& outcome) {
      if (const auto* told = std::get_if<control::SceneRecordings>(&outcome)) show(scene, *told);
    });
}

void AdminActions::record(ViewerSlot& slot, const std::string& action) {
  if (!callbacks_.record) return slot.viewer->send(refused(kNoRecordings));
  if (action != "start" && action != "stop")
    return slot.viewer->send(refused("a recording can be told start and stop, not " + action));
  const bool starts = action == "start";
  spdlog::info("scene {}: {} {} a recording", visible(slot.scene->name()), author(slot),
               starts ? "starts" : "stops");
  const std::size_t scene = slot.scene->index();
  ask_recorder(scene, starts ? control::RecordingAction::start : control::RecordingAction::stop,
               [this, scene, id = slot.id](const Recordings& outcome) {
                 if (const auto* no = std::get_if<control::Refused>(&outcome))
                   return answer(id, refused(no->reason));
                 show(scene, std::get<control::SceneRecordings>(outcome));
               });
}

/// Gives the viewer a ticket for a complete recording of its scene. The name must be one of those
/// that the recorder lists, so it is never part of a path.
void AdminActions::give_download(ViewerSlot& slot, const std::string& name) {
  if (!callbacks_.record) return slot.viewer->send(refused(kNoRecordings));
  ask_recorder(
      slot.scene->index(), control::RecordingAction::look,
      [this, name, id = slot.id, token = admin_token(slot)->id,
       scene = slot.scene->name()](const Recordings& outcome) {
        const auto* told = std::get_if<control::SceneRecordings>(&outcome);
        const Token* by = tokens_.find(token);
        if (told == nullptr) return answer(id, refused(std::get<control::Refused>(outcome).reason));
        if (by == nullptr) return;
        const auto kept = std::ranges::find(told->kept, name, &control::KeptRecording::name);
        if (kept == told->kept.end())
          return answer(id, refused("there is no complete recording '" + name + "' of this scene"));
        const Secret ticket = tickets_.mint(*by, scene, calendar_now(),
                                            std::filesystem::path(told->folder) / kept->name);
        answer(id, download_text(name, ticket.text()));
      });
}

std::optional<std::filesystem::path> AdminActions::redeem_download(std::string_view text) {
  auto ticket = tickets_.redeem(text, calendar_now());
  if (!ticket || ticket->file.empty()) return std::nullopt;
  tokens_.refresh();
  const Token* token = tokens_.find(ticket->token);
  if (token == nullptr || expired(*token, calendar_now()) || !covers(token->role, Role::admin) ||
      !opens(*token, ticket->scene))
    return std::nullopt;
  spdlog::info("scene {}: client {} (token {}) downloads {}", visible(ticket->scene),
               visible(token->client), token->id, visible(ticket->file.string()));
  return std::move(ticket->file);
}

}  // namespace feltwire::web
