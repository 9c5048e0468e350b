#include "server/control/control_service.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/token_text.hpp"
#include "core/base/visible_text.hpp"
#include "protocol/crypto/tls.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/session/protocol_versions.hpp"
#include "protocol/wire/session_secrets.hpp"
#include "server/control/pointer_limits.hpp"
#include "server/control/surface_requests.hpp"
#include "server/scene/parameter_changes.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// The answer to every bad token. It gives no reason, so that nobody learns which tokens exist.
constexpr const char* kNoGoodToken =
    "this needs a token that the server knows and that is still good; feltwire-server token add "
    "makes one";

}  // namespace

ControlService::ControlService(asio::io_context& io, SceneHosts& hosts, TokenFile tokens,
                               const ServiceLimits& limits, AdminService::Callbacks callbacks)
    : io_(io),
      hosts_(hosts),
      tokens_(std::move(tokens)),
      limits_(limits),
      wrong_tokens_(limits.join_rate, limits.join_burst),
      request_limits_(limits),
      admins_(io, hosts, directory_, request_limits_, std::move(callbacks)) {}

void ControlService::handle(ControlPeer& peer, control::Message request, ControlAnswer answer) {
  refresh_tokens();
  if (const auto* shown = std::get_if<control::Authenticate>(&request))
    return answer(authenticate(peer, *shown));
  const Token* token = good_token(peer.token);
  if (token == nullptr) {
    peer.token.clear();  // no valid token: the connection ends after this answer
    return answer(request_limits_.refuse(RefusalCode::unauthenticated, kNoGoodToken));
  }
  PendingRequest asked{peer, *token, std::move(answer)};
  if (auto* wanted = std::get_if<control::JoinRequest>(&request))
    return join(std::move(asked), std::move(*wanted));
  if (const auto* wanted = std::get_if<control::SetParameters>(&request))
    return change_session(std::move(asked), wanted->session, std::move(request));
  if (const auto* wanted = std::get_if<control::TakeSurfaces>(&request))
    return change_session(std::move(asked), wanted->session, std::move(request));
  if (const auto session = session_of_fetch(request))
    return asked.answer(fetch(*token, *session, request));
  if (auto refused = request_limits_.check_requests(token->client))
    return asked.answer(*std::move(refused));
  if (const auto* wanted = std::get_if<control::LeaveRequest>(&request))
    return pass_on(std::move(asked), wanted->session, std::move(request));
  if (std::holds_alternative<control::ListScenes>(request)) {
    if (auto refused = request_limits_.check_questions(*token))
      return asked.answer(*std::move(refused));
    return asked.answer(list_scenes(*token));
  }
  if (auto refused = refuse_elsewhere(request)) return asked.answer(*std::move(refused));
  if (admins_.handle(asked, request)) return;
  asked.answer(Refused{RefusalCode::malformed, "this message is an answer, not a request"});
}

control::Message ControlService::authenticate(ControlPeer& peer,
                                              const control::Authenticate& shown) {
  peer.token.clear();
  const Token* token = feltwire::authenticate(tokens_.tokens(), shown.token.text(), calendar_now());
  if (token != nullptr) {
    if (auto refused = request_limits_.check_requests(token->client)) return *std::move(refused);
    const ProtocolVersions ours;
    if (!common_version(shown.versions, ours)) {
      std::string reason = refused_client(shown.versions, ours);
      spdlog::warn("client {} (token {}) is refused: {}", visible(token->client), token->id,
                   reason);
      return request_limits_.refuse(RefusalCode::not_supported, std::move(reason));
    }
    peer.token = token->id;
    peer.client = token->client;
    return control::Authenticated{token->client, token->scene, token->role, ours};
  }
  // Count only wrong tokens: guesses must not lock out a client of the same network with a valid
  // token.
  if (!wrong_tokens_.take(peer.address, monotonic_now()))
    return request_limits_.refuse(
        RefusalCode::too_many,
        "too many wrong tokens from this address or its network; correct the token, or "
        "wait a moment");
  spdlog::info("{} has shown no token that is good", peer.address.to_string());
  return request_limits_.refuse(RefusalCode::unauthenticated, kNoGoodToken);
}

std::optional<Refused> ControlService::refuse_token(const Token& token,
                                                    const control::JoinRequest& request) {
  if (!covers(token.role, request.role))
    return request_limits_.refuse(RefusalCode::forbidden,
                                  "this token is for " + holder(token.role) +
                                      ", it does not join as " + std::string(name(request.role)));
  for (const std::string& given : {request.client, request.device.name, request.tool})
    if (has_token(given))
      return request_limits_.refuse(RefusalCode::forbidden,
                                    "a name in the request is an access token; names are shown to "
                                    "others, so choose another one");
  // Do not tell the holder of this token whether the scene exists.
  if (!opens(token, request.scene))
    return request_limits_.refuse(RefusalCode::forbidden,
                                  "this token does not open scene '" + request.scene + "'");
  if (!token.seat.empty() && !request.seat.empty() && request.seat != token.seat)
    return request_limits_.refuse(RefusalCode::forbidden, "this token is for the seat '" +
                                                              token.seat + "'; leave out --seat");
  return request_limits_.check_joins(token.client);
}

/// Returns who serves the scene. Without a fleet, every scene of this server is served here.
FleetMember::Answer ControlService::ask_fleet(const PendingRequest& asked,
                                              const control::JoinRequest& request) {
  if (fleet_ != nullptr) {
    const bool v6 = asked.peer.address.is_v6() && !asked.peer.address.to_v6().is_v4_mapped();
    const auto date = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    if (auto answer = fleet_->answer({.scene = request.scene,
                                      .client = asked.token.client,
                                      .role = request.role,
                                      .seen = request.epoch,
                                      .ticket = request.ticket,
                                      .follows_redirects = request.follows_redirects,
                                      .ipv6 = v6},
                                     monotonic_now(), date))
      return *std::move(answer);
  }
  if (!request.ticket.empty())
    return request_limits_.refuse(RefusalCode::bad_ticket,
                                  "this server is in no fleet that serves the scene");
  return FleetMember::Seat{};
}

/// Refuses an admin's change of a scene that another host of the fleet serves.
std::optional<Refused> ControlService::refuse_elsewhere(const control::Message& request) {
  if (fleet_ == nullptr) return std::nullopt;
  std::string_view scene;
  if (const auto* reload = std::get_if<control::ReloadScene>(&request)) scene = reload->scene;
  if (const auto* material = std::get_if<control::SetMaterial>(&request)) scene = material->scene;
  if (const auto* gravity = std::get_if<control::SetGravity>(&request)) scene = gravity->scene;
  if (scene.empty()) return std::nullopt;
  const auto host = fleet_->elsewhere(scene);
  if (!host) return std::nullopt;
  return request_limits_.refuse(
      RefusalCode::not_supported,
      "scene '" + std::string(scene) + "' is served by " + *host + "; ask that host");
}

std::optional<Refused> ControlService::refuse_join(const Token& token,
                                                   const control::JoinRequest& request) {
  const std::size_t scene = index_of_scene(hosts_, request.scene);
  if (scene == hosts_.size()) return unknown_scene(request.scene);
  if (request.role != Role::observer &&
      directory_.has_disturbed(token.client, scene, monotonic_now()))
    return request_limits_.refuse(RefusalCode::too_many,
                                  "a hand of client '" + token.client +
                                      "' broke the simulation of scene '" + request.scene +
                                      "' again and again; wait a minute, then move more gently");
  if (directory_.sessions_of(token.client) >= limits_.sessions_per_client)
    return request_limits_.refuse(RefusalCode::too_many,
                                  "client '" + token.client + "' has all its " +
                                      std::to_string(limits_.sessions_per_client) +
                                      " sessions; end one first");
  return refuse_pointer(request);
}

std::optional<Refused> ControlService::refuse_pointer(const control::JoinRequest& request) {
  if (request.role != Role::pointer) return std::nullopt;
  if (auto wrong = beyond_pointer(request))
    return request_limits_.refuse(RefusalCode::forbidden, *std::move(wrong));
  if (directory_.pointers() < limits_.pointers) return std::nullopt;
  return request_limits_.refuse(RefusalCode::too_many,
                                "this server has all its " + std::to_string(limits_.pointers) +
                                    " pointers (--web-hands); wait until one lets go");
}

void ControlService::join(PendingRequest asked, control::JoinRequest request) {
  const std::string who = visible(request.client + " (" + request.device.name + ", client " +
                                  asked.token.client + ", token " + asked.token.id + ")");
  if (const auto refused = refuse_token(asked.token, request))
    return refuse(asked, request, who, *refused);
  FleetMember::Answer fleet = ask_fleet(asked, request);
  if (const auto* refused = std::get_if<Refused>(&fleet))
    return refuse(asked, request, who, *refused);
  if (auto* redirected = std::get_if<control::Redirected>(&fleet)) {
    spdlog::info("{} is sent to {} port {} for scene {}", who, redirected->host.address,
                 redirected->host.port, visible(request.scene));
    return asked.answer(std::move(*redirected));
  }
  if (const auto refused = refuse_join(asked.token, request))
    return refuse(asked, request, who, *refused);
  // The scene's thread and the recordings need nothing of the fleet.
  request.ticket.clear();
  request.epoch = {};
  request.follows_redirects = false;
  const std::size_t scene = index_of_scene(hosts_, request.scene);
  const std::uint64_t id = new_session_id(scene);
  const CipherSuite suite = request.aes_256_gcm && has_aes_256_gcm()
                                ? CipherSuite::aes_256_gcm
                                : CipherSuite::chacha20_poly1305;
  const SessionKeys keys = random_session_keys(suite);
  SceneHost& host = *hosts_[scene];
  directory_.enter(id, {.token = asked.token.id,
                        .client = asked.token.client,
                        .tool = request.tool,
                        .scene = scene,
                        .scene_name = host.name(),
                        .role = request.role,
                        .who = who,
                        .since = monotonic_now(),
                        .fetches = TokenBucket(limits_.fetch_rate, limits_.fetch_burst)});
  if (!asked.token.seat.empty()) request.seat = asked.token.seat;
  request.lead_share = covers(request.role, Role::operator_) ? asked.token.lead_share : 0.0;
  const auto finish = [this, id, scene, keys, who, version = visible(request.version),
                       seat = std::get<FleetMember::Seat>(std::move(fleet)),
                       answer = std::move(asked.answer)](control::Message message) {
    const std::string& scene_name = hosts_[scene]->name();
    if (auto* accepted = std::get_if<control::JoinAccepted>(&message)) {
      accepted->port_offset = port_offset(hosts_, scene);
      put_keys(keys, *accepted);
      accepted->epoch = seat.epoch;
      accepted->hosts = seat.hosts;
      if (ListedSession* seated = directory_.find(id)) seated->parameters = accepted->parameters;
      spdlog::info("{} joined scene {} with feltwire {}", who, scene_name,
                   version.empty() ? "of no known version" : version);
    } else {
      directory_.erase(id);
      if (const auto* no = std::get_if<Refused>(&message))
        spdlog::warn("{} could not join scene {}: {}", who, scene_name, visible(no->reason));
    }
    answer(std::move(message));
  };
  try {
    host.ask(std::move(request), id, keys, io_, finish);
  } catch (...) {
    directory_.erase(id);
    throw;
  }
}

/// Logs and answers the refusal of a join.
void ControlService::refuse(PendingRequest& asked, const control::JoinRequest& request,
                            const std::string& who, const Refused& refused) {
  // Limit these log lines: a client may be refused a thousand times a second.
  if (refused_lines_.take(asked.token.client, monotonic_now()))
    spdlog::warn("{} could not join scene {}: {}", who, visible(request.scene),
                 visible(refused.reason));
  asked.answer(refused);
}

/// Sends a request that changes a session to the scene's thread, within the client's rate limit.
void ControlService::change_session(PendingRequest asked, std::uint64_t session,
                                    control::Message request) {
  if (auto refused = request_limits_.check_changes(asked.token.client))
    return asked.answer(*std::move(refused));
  pass_on(std::move(asked), session, std::move(request));
}

/// Sends a request to the thread of the session's scene, and the answer back. Refuses it unless the
/// session belongs to the token, or the token is an admin's.
void ControlService::pass_on(PendingRequest asked, std::uint64_t session,
                             control::Message request) {
  const ListedSession* seated = directory_.find_own(asked.token, session);
  if (seated == nullptr) return asked.answer(unknown_session(session));
  const std::string by = "client " + asked.token.client + " (token " + asked.token.id + ")";
  SessionParameters wanted;
  if (const auto* set = std::get_if<control::SetParameters>(&request)) wanted = set->parameters;
  const auto finish = [this, session, by, wanted = std::move(wanted), who = seated->who,
                       answer = std::move(asked.answer)](control::Message said) {
    if (std::holds_alternative<control::Left>(said)) {
      spdlog::info("{}: ended by {}", who, visible(by));
      // Forget the session now, so that the client may join again at once. The scene also reports
      // the end of the session, but perhaps after this answer.
      forget({{session, SessionEnd::asked}});
    }
    if (const auto* set = std::get_if<control::ParametersSet>(&said)) tell_of(*set, wanted, by);
    answer(std::move(said));
  };
  hosts_[seated->scene]->ask(std::move(request), session, {}, io_, finish);
}

/// Returns a list or a part of the scene to the client of a session, within the rate limit of the
/// session. A request for an unknown session counts against the limit on all requests of the
/// client.
control::Message ControlService::fetch(const Token& token, std::uint64_t session,
                                       const control::Message& request) {
  ListedSession* seated = directory_.find_own(token, session);
  if (seated == nullptr) {
    if (auto refused = request_limits_.check_requests(token.client)) return *std::move(refused);
    return unknown_session(session);
  }
  if (!seated->fetches.take(monotonic_now()))
    return request_limits_.refuse(RefusalCode::too_many,
                                  "session " + std::to_string(session) +
                                      " fetches surfaces too often; wait a moment, then "
                                      "go on where it stopped");
  return fetched(request, hosts_[seated->scene]->current_scene(), seated->tool);
}

/// Logs which parameters of a session were changed, and by which client (`by`).
void ControlService::tell_of(const control::ParametersSet& set, const SessionParameters& wanted,
                             const std::string& by) {
  ListedSession* found = directory_.find(set.session);
  if (found == nullptr) return;
  ListedSession& seated = *found;
  const bool of_client = set.parameters.side == BoundingSide::client;
  // If the client limits the force, this request does not change the bounding law: keep it out of
  // the log line. The scene logs the law when the client takes it.
  const SessionParameters before =
      of_client ? with_law(seated.parameters, law_of(set.parameters)) : seated.parameters;
  const bool asks = of_client && law_of(wanted) != law_of(set.parameters);
  const bool sets = before != set.parameters;
  if (sets)
    spdlog::info("{}: parameters set by {}: {}", seated.who, visible(by),
                 changes(before, set.parameters));
  if (asks) spdlog::info("{}: its client is asked by {} for another law", seated.who, visible(by));
  if (!asks && !sets)
    spdlog::info("{}: {} asks for the parameters that it has", seated.who, visible(by));
  seated.parameters = set.parameters;
}

control::Message ControlService::list_scenes(const Token& token) const {
  control::SceneList result;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    const SceneHost& host = *hosts_[i];
    if (!opens(token, host.name())) continue;
    result.scenes.push_back({host.name(), port_offset(hosts_, i), host.objects(), host.sessions()});
  }
  return result;
}

void ControlService::look_after() {
  admins_.look_after();
  refresh_tokens();
  for (const auto& [id, seated] : directory_.sessions()) {
    const Token* token = good_token(seated.token);
    if (token != nullptr && covers(token->role, seated.role) && opens(*token, seated.scene_name))
      continue;
    spdlog::info("a session of client {} ends: its token {} is good no more",
                 visible(seated.client), seated.token);
    hosts_[seated.scene]->evict(id);
  }
}

void ControlService::end_sessions(const std::vector<std::string>& scenes) {
  for (const auto& [id, seated] : directory_.sessions())
    if (std::ranges::count(scenes, seated.scene_name) > 0) hosts_[seated.scene]->evict(id);
}

void ControlService::forget(const std::vector<EndedSession>& sessions) {
  directory_.forget(sessions, monotonic_now());
}

const Token* ControlService::good_token(const std::string& id) const {
  const Token* token = find_token(tokens_.tokens(), id);
  return token != nullptr && !expired(*token, calendar_now()) ? token : nullptr;
}

void ControlService::refresh_tokens() {
  if (const auto wrong = tokens_.refresh())
    spdlog::error("{}; the tokens stay as they were", *wrong);
}

/// Returns a session id: 56 random bits above a low byte with the index of the scene.
std::uint64_t ControlService::new_session_id(std::size_t scene) {
  std::uint64_t bits = 0;
  while (bits == 0) bits = (std::uint64_t{random_()} << 32 | random_()) << 8;
  return bits | scene;
}

}  // namespace feltwire
