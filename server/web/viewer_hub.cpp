#include "server/web/viewer_hub.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/post.hpp"
#include "server/web/viewer_slot.hpp"

namespace feltwire::web {
namespace {

constexpr Nanoseconds kBetweenDescriptions = std::chrono::milliseconds(500);
constexpr Nanoseconds kBetweenTokenLooks = std::chrono::seconds(1);
constexpr const char* kFull = "this server has as many viewers as it may have; close another page";
constexpr const char* kFullButForAdmins =
    "this server has as many viewers as it may have, and keeps its last places for admins; close "
    "another page";
constexpr double kPointRate = 120.0;  // [1/s] more, and at once, for a viewer that may hold a hand

}  // namespace

ViewerHub::ViewerHub(asio::io_context& io, const Scenes& scenes, TokenFile tokens, PageHands* hands,
                     Reload reload, WriteFlight write_flight)
    : io_(io),
      tokens_(std::move(tokens)),
      hands_(hands),
      reload_(std::move(reload)),
      write_flight_(std::move(write_flight)),
      begin_(monotonic_now()) {
  for (SceneInView* scene : scenes) {
    stages_.push_back(std::make_unique<Stage>());
    stages_.back()->scene = scene;
  }
}

ViewerHub::~ViewerHub() = default;

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
  if (found == slots_.end() || found->second.messages.take(monotonic_now())) return;
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
    if (!act(slot, *said)) follow(slot, *said);
  } else if (said->token) {
    admit(slot, *said->token);
  } else {
    refuse(id, WebSocketClose::bad_token, "the first message has no token");
  }
}

/// Handles a message of an admitted viewer. The viewer may have left when this returns.
void ViewerHub::follow(ViewerSlot& slot, const ViewerMessage& said) {
  if (said.point) ++(slot.hand.point(*said.point) ? counters_.points : counters_.points_refused);
  if (said.hand == "release") slot.hand.release();
  if (said.hand == "take" && slot.stage != nullptr) {
    ++counters_.hands;
    slot.hand.take(slot.stage->scene->name(), said.mode.value_or(""));
  }
  if (said.watch) return watch(slot, *said.watch);
  if (said.ticket) give_ticket(slot, *said.ticket);
}

/// The reason why another viewer with this token has no place; empty: there is one. A client must
/// not keep the others out, and all others together must not keep an admin out.
std::optional<std::string> ViewerHub::no_place_for(const Token& token) const {
  std::size_t all = 0, of_client = 0, of_others = 0;
  for (const auto& [id, slot] : slots_) {
    if (slot.token.empty()) continue;
    ++all;
    if (slot.client == token.client) ++of_client;
    if (!slot.of_admin) ++of_others;
  }
  if (all >= kMostViewers) return kFull;
  if (of_client >= kMostViewersOfClient)
    return "this client's name has all its " + std::to_string(kMostViewersOfClient) +
           " viewers; close another page, or use a token with another name";
  if (!covers(token.role, Role::admin) && of_others >= kMostViewers - kPlacesForAdmins)
    return kFullButForAdmins;
  return std::nullopt;
}

/// Takes a place for a viewer with this token.
void ViewerHub::enter(ViewerSlot& slot, const Token& token) {
  ++counters_.viewers;
  slot.token = token.id;
  slot.client = token.client;
  slot.of_admin = covers(token.role, Role::admin);
  slot.viewer->admitted();
}

void ViewerHub::refresh_tokens() {
  if (const auto wrong = tokens_.refresh()) spdlog::error("{}", visible(*wrong));
}

const Token* ViewerHub::good_token(std::string_view text) {
  refresh_tokens();
  return authenticate(tokens_.tokens(), text, calendar_now());
}

bool ViewerHub::may_try_again(const ViewerSlot& slot) {
  ++counters_.refused;
  if (may_try_again(slot.address)) return true;
  refuse(slot.id, WebSocketClose::too_many,
         "too many wrong tokens from this address or its network; wait a minute");
  return false;
}

bool ViewerHub::may_try_again(const asio::ip::address& address) {
  return wrong_tokens_.take(address, monotonic_now());
}

void ViewerHub::admit(ViewerSlot& slot, std::string_view text) {
  const Token* token = good_token(text);
  if (token == nullptr) {
    if (may_try_again(slot)) refuse(slot.id, WebSocketClose::bad_token, kNoGoodToken);
    return;
  }
  std::vector<std::string> scenes;
  for (const auto& stage : stages_)
    if (opens(*token, stage->scene->name())) scenes.push_back(stage->scene->name());
  if (scenes.empty()) {
    ++counters_.refused;
    return refuse(slot.id, WebSocketClose::bad_token, "the token opens no scene of this server");
  }
  if (const auto reason = no_place_for(*token)) {
    ++counters_.refused;
    return refuse(slot.id, WebSocketClose::too_many, *reason);
  }
  enter(slot, *token);
  spdlog::debug("live page: {} looks on", visible(token->client));
  const bool observes =
      std::ranges::all_of(stages_, [](const auto& s) { return s->scene->controls() == nullptr; });
  slot.viewer->send(hello(scenes, token->role, observes));
  if (hands_ != nullptr && covers(token->role, Role::pointer)) {
    slot.hand = ViewersHand(*hands_, token->client, Secret(text));
    slot.messages = TokenBucket(kMessageRate + kPointRate, kMessageBurst + kPointRate);
  }
  watch(slot, scenes.front());
}

bool ViewerHub::opens_something(std::string_view text) { return good_token(text) != nullptr; }

void ViewerHub::admit(Id id, const ViewTicket& ticket) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  const Token* token = find_token(tokens_.tokens(), ticket.token);
  if (token == nullptr) {
    ++counters_.refused;
    return refuse(id, WebSocketClose::bad_token, kNoGoodToken);
  }
  if (const auto reason = no_place_for(*token)) {
    ++counters_.refused;
    return refuse(id, WebSocketClose::too_many, *reason);
  }
  ViewerSlot& slot = found->second;
  enter(slot, *token);
  watch(slot, ticket.scene);  // refuses if the token no longer opens that scene
  if (const auto still = slots_.find(id); still != slots_.end())
    still->second.foxglove.emplace(*still->second.viewer, ticket.scene);
}

std::optional<Secret> ViewerHub::mint_ticket(const Token& by, std::string_view scene) {
  const auto shown = std::ranges::find_if(stages_, [&](const auto& stage) {
    const std::string& name = stage->scene->name();
    return (scene.empty() || name == scene) && opens(by, name);
  });
  if (shown == stages_.end()) return std::nullopt;
  ++counters_.tickets;
  return tickets_.mint(by, (*shown)->scene->name(), calendar_now());
}

std::optional<Secret> ViewerHub::mint_ticket(std::string_view text, std::string_view scene) {
  const Token* token = authenticate(tokens_.tokens(), text, calendar_now());
  return token != nullptr ? mint_ticket(*token, scene) : std::nullopt;
}

std::optional<ViewTicket> ViewerHub::redeem_ticket(std::string_view text) {
  auto ticket = tickets_.redeem(text, calendar_now());
  if (!ticket) ++counters_.refused;
  return ticket;
}

void ViewerHub::give_ticket(ViewerSlot& slot, std::string_view scene) {
  const Token* token = find_token(tokens_.tokens(), slot.token);
  const auto minted = token != nullptr ? mint_ticket(*token, scene) : std::nullopt;
  if (!minted)
    return refuse(slot.id, WebSocketClose::bad_message,
                  "there is no such scene, or the token does not open it");
  slot.viewer->send(ticket_text(scene, minted->text(), ViewTickets::kLife));
}

void ViewerHub::watch(ViewerSlot& slot, std::string_view scene) {
  const Token* token = find_token(tokens_.tokens(), slot.token);
  for (const auto& stage : stages_) {
    if (stage->scene->name() != scene || token == nullptr || !opens(*token, scene)) continue;
    if (slot.stage != stage.get()) slot.hand.release();
    slot.stage = stage.get();
    slot.version = 0;
    return;
  }
  refuse(slot.id, WebSocketClose::bad_message,
         "there is no such scene, or the token does not open it");
}

bool ViewerHub::watched(const Stage& stage) const {
  return std::ranges::any_of(slots_,
                             [&](const auto& entry) { return entry.second.stage == &stage; });
}

/// Ends the access that revoked and expired tokens opened.
void ViewerHub::look_after_tokens(Nanoseconds now) {
  if (now - looked_at_tokens_ < kBetweenTokenLooks) return;
  looked_at_tokens_ = now;
  refresh_tokens();
  std::vector<Id> gone;
  for (const auto& [id, slot] : slots_) {
    if (slot.token.empty()) continue;
    const Token* token = find_token(tokens_.tokens(), slot.token);
    if (token == nullptr || expired(*token, calendar_now())) gone.push_back(id);
  }
  for (const Id id : gone)
    refuse(id, WebSocketClose::bad_token, "the token has been revoked or has expired");
}

void ViewerHub::tick(Nanoseconds now) {
  look_after_tokens(now);
  for (auto& [id, slot] : slots_)
    if (const auto news = slot.hand.news()) slot.viewer->send(*news);
  for (const auto& stage : stages_)
    if (watched(*stage)) show(*stage, now);
}

void ViewerHub::show(Stage& stage, Nanoseconds now) {
  const SceneInView::CurrentScene current = stage.scene->current_scene();
  if (current.version != stage.version) {
    stage.text = SharedBytes(scene_text(*current.scene, current.version));
    stage.geometry.clear();
    for (Bytes& object : geometry(*current.scene, current.version))
      stage.geometry.emplace_back(std::move(object));
    stage.version = current.version;
    stage.materials = {};
  }
  if (stage.materials.empty() || current.changes != stage.changes) {
    stage.materials = SharedBytes(materials_text(*current.scene, current.version, current.gravity));
    stage.changes = current.changes;
  }
  tell_of_sight(stage);
  // Skip a viewer that has not yet taken the previous message.
  std::vector<ViewerSlot*> ready;
  for (auto& [id, slot] : slots_) {
    if (slot.stage != &stage || slot.foxglove) continue;
    if (slot.viewer->ready())
      ready.push_back(&slot);
    else
      ++counters_.skipped;
  }
  for (ViewerSlot* slot : ready)
    if (slot->version != stage.version) {
      show_scene(stage, *slot);
    } else if (slot->changes != stage.changes) {
      slot->changes = stage.changes;
      slot->viewer->show_text(stage.materials);
    }

  const bool news = stage.scene->take_picture(stage.picture);
  if (news && stage.picture.version == stage.version) {
    const SharedBytes shown(picture(stage.picture, stage.rates, begin_));
    const SharedBytes near(surfaces(stage.picture));
    for (ViewerSlot* slot : ready) {
      slot->viewer->show_binary(shown);
      if (!near.empty()) slot->viewer->show_binary(near);
    }
    counters_.pictures += ready.size();
  }
  show_elsewhere(stage, now, news);
  if (now - stage.described < kBetweenDescriptions || stage.describing) return;
  stage.described = now;
  stage.describing = true;
  count_rates(stage);
  const SharedBytes text(sessions(stage.hands, stage.picture, stage.rates, seconds(now - begin_)));
  for (ViewerSlot* slot : ready) slot->viewer->show_text(text);
  stage.scene->describe(
      post_to(io_), [&stage, alive = std::weak_ptr(alive_)](std::vector<HandDescription> hands) {
        if (alive.expired()) return;
        stage.hands = std::move(hands);
        stage.describing = false;
      });
}

std::optional<std::string> ViewerHub::hidden_scene(std::string_view text) {
  std::vector<std::string> hidden;
  for (const auto& stage : stages_)
    if (stage->scene->out_of_sight()) hidden.push_back(stage->scene->name());
  if (hidden.empty()) return std::nullopt;
  const Token* token = text.empty() ? nullptr : good_token(text);
  const auto opened = std::ranges::find_if(
      hidden, [&](const std::string& name) { return token != nullptr && opens(*token, name); });
  return opened != hidden.end() ? *opened : std::string();
}

/// Tells the viewers when the scene is lost from view and when it is back.
void ViewerHub::tell_of_sight(Stage& stage) {
  std::optional<std::string> hidden = stage.scene->out_of_sight();
  if (hidden == stage.hidden) return;
  const std::string line = hidden ? log_text("error", *hidden)
                                  : log_text("info", "Scene " + stage.scene->name() + " is seen.");
  stage.hidden = std::move(hidden);
  for (const auto& [id, slot] : slots_)
    if (slot.stage == &stage && !slot.foxglove && slot.version != 0) slot.viewer->send(line);
}

/// Shows the scene to viewers that use the Foxglove protocol.
void ViewerHub::show_elsewhere(Stage& stage, Nanoseconds now, bool news) {
  bool encoded = false;
  for (auto& [id, slot] : slots_) {
    if (slot.stage != &stage || !slot.foxglove) continue;
    if (!slot.viewer->ready()) {
      ++counters_.skipped;
      continue;
    }
    if (!std::exchange(encoded, true)) {
      stage.foxglove.set(*stage.scene->current_scene().scene, stage.version, now);
      if (news && stage.picture.version == stage.version) stage.foxglove.set(stage.picture);
    }
    slot.foxglove->show(stage.foxglove);
    if (news) ++counters_.pictures;
  }
}

void ViewerHub::show_scene(Stage& stage, ViewerSlot& slot) {
  slot.version = stage.version;
  slot.changes = stage.changes;
  slot.viewer->show_text(stage.text);
  for (const SharedBytes& object : stage.geometry) slot.viewer->show_binary(object);
  slot.viewer->show_text(stage.materials);
  if (stage.hidden) slot.viewer->send(log_text("error", *stage.hidden));
}

/// Computes the rates from the newest picture's counters and those of half a second before.
void ViewerHub::count_rates(Stage& stage) {
  const double elapsed = seconds(stage.picture.time - stage.counted.time);
  stage.rates.clear();
  for (const PictureHand& hand : stage.picture.hands) {
    HandRates rates;
    rates.number = hand.number;
    const auto before = std::ranges::find(stage.counted.hands, hand.number, &PictureHand::number);
    if (before != stage.counted.hands.end() && elapsed > 0.0) {
      const auto taken = static_cast<double>(hand.samples - before->samples);
      const auto missed = static_cast<double>(hand.missed - before->missed);
      rates.samples = taken / elapsed;
      rates.loss = taken + missed > 0.0 ? missed / (taken + missed) : 0.0;
    }
    stage.rates.push_back(rates);
  }
  std::ranges::sort(stage.rates, {}, &HandRates::number);
  stage.counted = stage.picture;
}

void ViewerHub::close_all() {
  std::vector<Id> all;
  for (const auto& [id, slot] : slots_) all.push_back(id);
  for (const Id id : all) refuse(id, WebSocketClose::going_away, "the server ends");
}

}  // namespace feltwire::web
