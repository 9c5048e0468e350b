#include "server/web/viewer_hub.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "server/web/page_messages.hpp"

namespace feltwire::web {
namespace {

constexpr Nanoseconds kBetweenTokenLooks = std::chrono::seconds(1);
constexpr const char* kNoGoodToken = "the token is not good: it is unknown, revoked or expired";
constexpr const char* kFull = "this server has as many viewers as it may have; close another page";
constexpr const char* kFullButForAdmins =
    "this server has as many viewers as it may have, and keeps its last places for admins; close "
    "another page";
// [1/s] The message rate and burst of a viewer that may hold a hand are larger by this value.
constexpr double kPointRate = 120.0;

/// Returns the reason why another viewer with this token is refused; empty if it is not. One client
/// must not take the places of the others, and the last places are for admins.
std::optional<std::string> no_place_for(const Token& token, const ViewerSlots& slots) {
  std::size_t all = 0, of_client = 0, of_others = 0;
  for (const auto& [id, slot] : slots) {
    if (slot.token.empty()) continue;
    ++all;
    if (slot.client == token.client) ++of_client;
    if (!slot.of_admin) ++of_others;
  }
  if (all >= ViewerHub::kMostViewers) return kFull;
  if (of_client >= ViewerHub::kMostViewersOfClient)
    return "this client's name has all its " + std::to_string(ViewerHub::kMostViewersOfClient) +
           " viewers; close another page, or use a token with another name";
  if (!covers(token.role, Role::admin) &&
      of_others >= ViewerHub::kMostViewers - ViewerHub::kPlacesForAdmins)
    return kFullButForAdmins;
  return std::nullopt;
}

/// Stores the token of a viewer, and tells the viewer's connection that it may stay.
void enter(ViewerSlot& slot, const Token& token) {
  slot.token = token.id;
  slot.client = token.client;
  slot.of_admin = covers(token.role, Role::admin);
  slot.viewer->admitted();
}

}  // namespace

ViewerHub::ViewerHub(asio::io_context& io, const Scenes& scenes, TokenFile tokens, PageHands* hands,
                     AdminActions::Callbacks admins)
    : tokens_(std::move(tokens)),
      hands_(hands),
      admins_(io, tokens_, tickets_, slots_, std::move(admins)) {
  const Nanoseconds begin = monotonic_now();
  for (SceneInView* scene : scenes)
    scenes_.push_back(std::make_unique<ViewedScene>(io, *scene, scenes_.size(), begin));
}

ViewerHub::Id ViewerHub::join(Viewer& viewer, const asio::ip::address& address) {
  const Id id = next_id_++;
  slots_.try_emplace(id, id, &viewer, address);
  return id;
}

void ViewerHub::leave(Id id) { slots_.erase(id); }

void ViewerHub::refuse(Id id, WebSocketClose code, const std::string& reason) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  Viewer* viewer = found->second.viewer;
  slots_.erase(found);
  viewer->close(code, reason);
}

void ViewerHub::count(Id id) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  const Nanoseconds now = monotonic_now();
  if (found->second.pings) found->second.pings->hear(now);
  if (found->second.messages.take(now)) return;
  refuse(id, WebSocketClose::bad_message, "too many messages");
}

void ViewerHub::receive(Id id, std::string_view message) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  ViewerSlot& slot = found->second;
  if (slot.foxglove) return slot.foxglove->receive(message);
  const std::optional<ViewerMessage> said = parse_viewer_message(message);
  if (!said) return refuse(id, WebSocketClose::bad_message, "a message is not a JSON object");
  if (!slot.token.empty()) {
    switch (admins_.handle(slot, *said)) {
      case AdminActions::Outcome::not_asked:
        return follow(slot, *said);
      case AdminActions::Outcome::wrong_token:
        if (may_try_again(slot)) slot.viewer->send(refused(kNoGoodToken));
        return;
      case AdminActions::Outcome::handled:
        return;
    }
  } else if (said->token) {
    admit(slot, *said->token);
  } else {
    refuse(id, WebSocketClose::bad_token, "the first message has no token");
  }
}

/// Handles a message of an admitted viewer, except the actions of admins. The viewer may have left
/// when this returns.
void ViewerHub::follow(ViewerSlot& slot, const ViewerMessage& said) {
  if (said.point) ++(slot.hand.point(*said.point) ? counters_.points : counters_.points_refused);
  if (said.hand == "release") slot.hand.release();
  if (said.hand == "take" && slot.scene != nullptr) {
    ++counters_.hands;
    slot.hand.take(slot.scene->name(), said.mode.value_or(""));
  }
  if (said.watch) return watch(slot, *said.watch);
  if (said.ticket) give_ticket(slot, *said.ticket);
}

/// Counts a wrong token. If there were too many, refuses the viewer and returns false.
bool ViewerHub::may_try_again(const ViewerSlot& slot) {
  ++counters_.refused;
  if (tokens_.may_try_again(slot.address)) return true;
  refuse(slot.id, WebSocketClose::too_many,
         "too many wrong tokens from this address or its network; wait a minute");
  return false;
}

void ViewerHub::admit(ViewerSlot& slot, std::string_view text) {
  tokens_.refresh();
  const Token* token = tokens_.authenticate(text);
  if (token == nullptr) {
    if (may_try_again(slot)) refuse(slot.id, WebSocketClose::bad_token, kNoGoodToken);
    return;
  }
  std::vector<std::string> scenes;
  for (const auto& scene : scenes_)
    if (opens(*token, scene->name())) scenes.push_back(scene->name());
  if (scenes.empty()) {
    ++counters_.refused;
    return refuse(slot.id, WebSocketClose::bad_token, "the token opens no scene of this server");
  }
  if (const auto reason = no_place_for(*token, slots_)) {
    ++counters_.refused;
    return refuse(slot.id, WebSocketClose::too_many, *reason);
  }
  ++counters_.viewers;
  enter(slot, *token);
  spdlog::debug("live page: {} looks on", visible(token->client));
  const bool observes =
      std::ranges::all_of(scenes_, [](const auto& s) { return s->source().controls() == nullptr; });
  slot.viewer->send(hello(scenes, token->role, observes));
  if (hands_ != nullptr && covers(token->role, Role::pointer)) {
    slot.hand = ViewersHand(*hands_, token->client, Secret(text));
    slot.messages = TokenBucket(kMessageRate + kPointRate, kMessageBurst + kPointRate);
  }
  watch(slot, scenes.front());
}

void ViewerHub::admit(Id id, const ViewTicket& ticket) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  const Token* token = tokens_.find(ticket.token);
  if (token == nullptr) {
    ++counters_.refused;
    return refuse(id, WebSocketClose::bad_token, kNoGoodToken);
  }
  if (const auto reason = no_place_for(*token, slots_)) {
    ++counters_.refused;
    return refuse(id, WebSocketClose::too_many, *reason);
  }
  ViewerSlot& slot = found->second;
  ++counters_.viewers;
  enter(slot, *token);
  watch(slot, ticket.scene);  // refuses the viewer if the token no longer opens the scene
  if (const auto still = slots_.find(id); still != slots_.end()) {
    still->second.foxglove.emplace(*still->second.viewer, ticket.scene);
    still->second.pings.emplace(monotonic_now());
  }
}

std::optional<Secret> ViewerHub::mint_ticket(const Token* token, std::string_view scene) {
  if (token == nullptr) return std::nullopt;
  const auto shown = std::ranges::find_if(scenes_, [&](const auto& one) {
    return (scene.empty() || one->name() == scene) && opens(*token, one->name());
  });
  if (shown == scenes_.end()) return std::nullopt;
  ++counters_.tickets;
  return tickets_.mint(*token, (*shown)->name(), calendar_now());
}

std::optional<ViewTicket> ViewerHub::redeem_ticket(std::string_view text) {
  auto ticket = tickets_.redeem(text, calendar_now());
  if (ticket && !ticket->file.empty()) ticket.reset();
  if (!ticket) ++counters_.refused;
  return ticket;
}

std::optional<std::filesystem::path> ViewerHub::redeem_download(std::string_view text) {
  auto file = admins_.redeem_download(text);
  if (!file) ++counters_.refused;
  return file;
}

void ViewerHub::give_ticket(ViewerSlot& slot, std::string_view scene) {
  const auto minted = mint_ticket(tokens_.find(slot.token), scene);
  if (!minted)
    return refuse(slot.id, WebSocketClose::bad_message,
                  "there is no such scene, or the token does not open it");
  slot.viewer->send(ticket_text(scene, minted->text(), ViewTickets::kLife));
}

void ViewerHub::watch(ViewerSlot& slot, std::string_view scene) {
  const Token* token = tokens_.find(slot.token);
  for (const auto& wanted : scenes_) {
    if (wanted->name() != scene || token == nullptr || !opens(*token, scene)) continue;
    if (slot.scene != wanted.get()) slot.hand.release();
    slot.scene = wanted.get();
    slot.version = 0;
    return;
  }
  refuse(slot.id, WebSocketClose::bad_message,
         "there is no such scene, or the token does not open it");
}

/// Refuses viewers whose token was revoked or has expired. Checks this once a second.
void ViewerHub::look_after_tokens(Nanoseconds now) {
  if (now - looked_at_tokens_ < kBetweenTokenLooks) return;
  looked_at_tokens_ = now;
  tokens_.refresh();
  std::vector<Id> gone;
  for (const auto& [id, slot] : slots_) {
    if (slot.token.empty()) continue;
    const Token* token = tokens_.find(slot.token);
    if (token == nullptr || expired(*token, calendar_now())) gone.push_back(id);
  }
  for (const Id id : gone)
    refuse(id, WebSocketClose::bad_token, "the token has been revoked or has expired");
}

/// Pings the viewers that have said nothing for a while. Refuses those that answer no ping: their
/// machine or their network is gone.
void ViewerHub::ping(Nanoseconds now) {
  std::vector<Id> gone;
  for (auto& [id, slot] : slots_) {
    if (!slot.pings) continue;
    const PingSchedule::Step step = slot.pings->step(now);
    if (step == PingSchedule::Step::ping) slot.viewer->ping();
    if (step == PingSchedule::Step::gone) gone.push_back(id);
  }
  for (const Id id : gone) refuse(id, WebSocketClose::going_away, "no ping was answered");
}

void ViewerHub::tick(Nanoseconds now) {
  look_after_tokens(now);
  ping(now);
  admins_.look_after(now);
  for (auto& [id, slot] : slots_)
    if (const auto news = slot.hand.news()) slot.viewer->send(*news);
  std::vector<ViewerSlot*> watching;
  for (const auto& scene : scenes_) {
    watching.clear();
    for (auto& [id, slot] : slots_)
      if (slot.scene == scene.get()) watching.push_back(&slot);
    if (!watching.empty()) scene->show(watching, now);
  }
}

std::optional<std::string> ViewerHub::hidden_scene(std::string_view text) {
  std::vector<std::string> hidden;
  for (const auto& scene : scenes_)
    if (scene->source().out_of_sight()) hidden.push_back(scene->name());
  if (hidden.empty()) return std::nullopt;
  if (!text.empty()) tokens_.refresh();
  const Token* token = text.empty() ? nullptr : tokens_.authenticate(text);
  const auto opened = std::ranges::find_if(
      hidden, [&](const std::string& name) { return token != nullptr && opens(*token, name); });
  return opened != hidden.end() ? *opened : std::string();
}

void ViewerHub::tell(std::size_t scene, const std::optional<std::string>& wrong) {
  const ViewedScene* loaded = scenes_.at(scene).get();
  const std::string line =
      wrong ? log_text("error", *wrong)
            : log_text("info", "Scene " + loaded->name() + " was reloaded from its file.");
  for (const auto& [id, slot] : slots_)
    if (slot.scene == loaded && !slot.foxglove && (!wrong || admins_.is_admin(slot)))
      slot.viewer->send(line);
}

ViewerHubCounters ViewerHub::counters() const {
  ViewerHubCounters all = counters_;
  for (const auto& scene : scenes_) {
    all.pictures += scene->pictures();
    all.skipped += scene->skipped();
  }
  return all;
}

void ViewerHub::close_all() {
  std::vector<Id> all;
  for (const auto& [id, slot] : slots_) all.push_back(id);
  for (const Id id : all) refuse(id, WebSocketClose::going_away, "the server ends");
}

}  // namespace feltwire::web
