#include "server/control/control_service.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "core/base/visible_text.hpp"
#include "protocol/crypto/tls.hpp"
#include "protocol/net/clock.hpp"
#include "server/control/pending_request.hpp"
#include "server/control/pointer_limits.hpp"
#include "server/scene/parameter_changes.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// All bad tokens get this answer, so that nobody learns which tokens exist.
constexpr const char* kNoGoodToken =
    "this needs a token that the server knows and that is still good; feltwire-server token add "
    "makes one";

}  // namespace

std::string holder(Role role) {
  return (role == Role::pointer || role == Role::follower ? "a " : "an ") + std::string(name(role));
}

ControlService::ControlService(asio::io_context& io, Hosts& hosts, TokenFile tokens,
                               const ServiceLimits& limits, Reload reload,
                               std::function<ControlCounters()> connections,
                               WriteFlight write_flight)
    : io_(io),
      hosts_(hosts),
      tokens_(std::move(tokens)),
      limits_(limits),
      wrong_tokens_(limits.join_rate, limits.join_burst),
      joins_(limits.join_rate, limits.join_burst),
      changes_(limits.join_rate, limits.join_burst),
      looks_(limits.join_rate, limits.join_burst),
      requests_(limits.request_rate, limits.request_burst),
      reload_(std::move(reload)),
      connections_(std::move(connections)),
      write_flight_(std::move(write_flight)) {}

void ControlService::handle(ControlPeer& peer, control::Message request, Answer answer) {
  refresh_tokens();
  if (const auto* shown = std::get_if<control::Authenticate>(&request))
    return answer(authenticate(peer, *shown));
  const Token* token = good_token(peer.token);
  if (token == nullptr) {
    peer.token.clear();  // revoked since: the connection ends with this answer
    return answer(refuse(RefusalCode::unauthenticated, kNoGoodToken));
  }
  PendingRequest asked{peer, *token, std::move(answer)};
  if (auto* wanted = std::get_if<control::JoinRequest>(&request))
    return join(std::move(asked), std::move(*wanted));
  if (const auto* wanted = std::get_if<control::LeaveRequest>(&request)) {
    if (auto refused = refuse_endless(token->client)) return asked.answer(*std::move(refused));
    return pass_on(std::move(asked), wanted->session, std::move(request));
  }
  if (const auto* wanted = std::get_if<control::SetParameters>(&request)) {
    if (auto refused = refuse_hasty(asked)) return asked.answer(*std::move(refused));
    return pass_on(std::move(asked), wanted->session, std::move(request));
  }
  if (serve_surfaces(asked, request)) return;
  if (auto refused = refuse_endless(token->client)) return asked.answer(*std::move(refused));
  if (std::holds_alternative<control::ListScenes>(request)) {
    if (auto refused = refuse_curious(asked)) return asked.answer(*std::move(refused));
    return asked.answer(list_scenes(*token));
  }
  if (serve_observer(asked, request) || serve_admin(asked, request)) return;
  asked.answer(Refused{RefusalCode::malformed, "this message is an answer, not a request"});
}

control::Message ControlService::authenticate(ControlPeer& peer,
                                              const control::Authenticate& shown) {
  peer.token.clear();
  const Token* token = feltwire::authenticate(tokens_.tokens(), shown.token.text(), calendar_now());
  if (token != nullptr) {
    if (auto refused = refuse_endless(token->client)) return *std::move(refused);
    peer.token = token->id;
    peer.client = token->client;
    return control::Authenticated{token->client, token->scene, token->role};
  }
  // Only wrong tokens count: guesses must not lock out a neighbour with a good token.
  if (!wrong_tokens_.take(peer.address, monotonic_now()))
    return refuse(RefusalCode::too_many,
                  "too many wrong tokens from this address or its network; correct the token, or "
                  "wait a moment");
  spdlog::info("{} has shown no token that is good", peer.address.to_string());
  return refuse(RefusalCode::unauthenticated, kNoGoodToken);
}

std::optional<Refused> ControlService::refuse_join(const PendingRequest& asked,
                                                   const control::JoinRequest& request) {
  const Token& token = asked.token;
  if (!covers(token.role, request.role))
    return refuse(RefusalCode::forbidden, "this token is for " + holder(token.role) +
                                              ", it does not join as " +
                                              std::string(name(request.role)));
  // Do not tell this token whether the scene exists.
  if (!opens(token, request.scene))
    return refuse(RefusalCode::forbidden, "this token does not open scene '" + request.scene + "'");
  if (!token.seat.empty() && !request.seat.empty() && request.seat != token.seat)
    return refuse(RefusalCode::forbidden,
                  "this token is for the seat '" + token.seat + "'; leave out --seat");
  if (!joins_.take(token.client, monotonic_now()))
    return refuse(RefusalCode::too_many,
                  "client '" + token.client + "' joins too often; wait a moment");
  if (scene_of(request.scene) == hosts_.size())
    return Refused{
        RefusalCode::unknown_scene,
        "there is no scene '" + request.scene + "' here; list the scenes to see which there are"};
  const auto disturber = disturbers_.find({token.client, scene_of(request.scene)});
  if (request.role != Role::observer && disturber != disturbers_.end() &&
      monotonic_now() < disturber->second)
    return refuse(RefusalCode::too_many,
                  "a hand of client '" + token.client + "' broke the simulation of scene '" +
                      request.scene + "' again and again; wait a minute, then move more gently");
  const auto same_client = [&](const auto& entry) { return entry.second.client == token.client; };
  const auto sessions = std::count_if(seated_.begin(), seated_.end(), same_client);
  if (static_cast<std::size_t>(sessions) >= limits_.sessions_per_client)
    return refuse(RefusalCode::too_many, "client '" + token.client + "' has all its " +
                                             std::to_string(limits_.sessions_per_client) +
                                             " sessions; end one first");
  return refuse_pointer(request);
}

std::optional<Refused> ControlService::refuse_pointer(const control::JoinRequest& request) {
  if (request.role != Role::pointer) return std::nullopt;
  if (auto wrong = beyond_pointer(request))
    return refuse(RefusalCode::forbidden, *std::move(wrong));
  const auto pointers = std::ranges::count_if(
      seated_, [](const auto& entry) { return entry.second.role == Role::pointer; });
  if (static_cast<std::size_t>(pointers) < limits_.pointers) return std::nullopt;
  return refuse(RefusalCode::too_many, "this server has all its " +
                                           std::to_string(limits_.pointers) +
                                           " pointers (--web-hands); wait until one lets go");
}

void ControlService::join(PendingRequest asked, control::JoinRequest request) {
  const std::string who = visible(request.client + " (" + request.device.name + ", client " +
                                  asked.token.client + ", token " + asked.token.id + ")");
  if (const auto refused = refuse_join(asked, request)) {
    // Limit these log lines: a client may be refused a thousand times a second.
    if (refused_lines_.take(asked.token.client, monotonic_now()))
      spdlog::warn("{} could not join scene {}: {}", who, visible(request.scene),
                   visible(refused->reason));
    return asked.answer(*refused);
  }
  const std::size_t scene = scene_of(request.scene);
  const std::uint64_t id = new_session_id(scene);
  const CipherSuite suite = request.aes_256_gcm && has_aes_256_gcm()
                                ? CipherSuite::aes_256_gcm
                                : CipherSuite::chacha20_poly1305;
  SessionKeys keys;
  try {
    keys = asked.peer.keys(id, suite);
  } catch (const std::exception& error) {
    spdlog::error("{} could not join: {}", who, error.what());
    return asked.answer(Refused{RefusalCode::not_supported, "this connection gives no keys"});
  }
  seated_.insert_or_assign(id, ListedSession{asked.token.id,
                                             asked.token.client,
                                             request.tool,
                                             scene,
                                             request.role,
                                             who,
                                             monotonic_now(),
                                             {},
                                             TokenBucket(limits_.fetch_rate, limits_.fetch_burst)});
  if (!asked.token.seat.empty()) request.seat = asked.token.seat;
  request.lead_share = covers(request.role, Role::operator_) ? asked.token.lead_share : 0.0;
  SceneHost& host = *hosts_[scene];
  const auto finish = [this, id, scene, suite, who, version = visible(request.version),
                       answer = std::move(asked.answer)](control::Message message) {
    const std::string& scene_name = hosts_[scene]->name();
    if (auto* accepted = std::get_if<control::JoinAccepted>(&message)) {
      accepted->port_offset = static_cast<std::uint16_t>(1 + scene);
      accepted->suite = suite;
      if (const auto seated = seated_.find(id); seated != seated_.end())
        seated->second.parameters = accepted->parameters;
      spdlog::info("{} joined scene {} with feltwire {}", who, scene_name,
                   version.empty() ? "of no known version" : version);
    } else {
      seated_.erase(id);
      if (const auto* no = std::get_if<Refused>(&message))
        spdlog::warn("{} could not join scene {}: {}", who, scene_name, visible(no->reason));
    }
    answer(std::move(message));
  };
  try {
    host.ask(std::move(request), id, keys, io_, finish);
  } catch (...) {
    seated_.erase(id);
    throw;
  }
}

/// Passes it on to the scene if the session is the asker's own, or the asker is an admin.
void ControlService::pass_on(PendingRequest asked, std::uint64_t session,
                             control::Message request) {
  const ListedSession* seated = own_session(asked, session);
  if (seated == nullptr) return asked.answer(unknown_session(session));
  const std::string by = "client " + asked.token.client + " (token " + asked.token.id + ")";
  SessionParameters wanted;
  if (const auto* set = std::get_if<control::SetParameters>(&request)) wanted = set->parameters;
  const auto finish = [this, session, by, wanted = std::move(wanted), who = seated->who,
                       answer = std::move(asked.answer)](control::Message said) {
    if (std::holds_alternative<control::Left>(said)) {
      spdlog::info("{}: ended by {}", who, visible(by));
      // The scene reports this too, perhaps after this answer. Its place is free from now on.
      forget({{session, SessionEnd::asked}});
    }
    if (const auto* set = std::get_if<control::ParametersSet>(&said)) tell_of(*set, wanted, by);
    answer(std::move(said));
  };
  hosts_[seated->scene]->ask(std::move(request), session, {}, io_, finish);
}

/// The session if it is the asker's, or the asker is an admin of its scene; else null.
ControlService::ListedSession* ControlService::own_session(const PendingRequest& asked,
                                                           std::uint64_t id) {
  const auto found = seated_.find(id);
  if (found == seated_.end()) return nullptr;
  const bool may =
      found->second.token == asked.token.id ||
      (covers(asked.token.role, Role::admin) && opens(asked.token, scene_name(found->second)));
  return may ? &found->second : nullptr;
}

/// Logs which parameters of a session were changed, and by whom.
void ControlService::tell_of(const control::ParametersSet& set, const SessionParameters& wanted,
                             const std::string& by) {
  const auto found = seated_.find(set.session);
  if (found == seated_.end()) return;
  ListedSession& seated = found->second;
  const bool of_client = set.parameters.side == BoundingSide::client;
  // A client's law is never set here. The scene has logged the law that the client took.
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

/// Limits requests that cost work of a scene's thread or of the machine.
std::optional<Refused> ControlService::refuse_hasty(const PendingRequest& asked) {
  if (changes_.take(asked.token.client, monotonic_now())) return std::nullopt;
  return refuse(
      RefusalCode::too_many,
      "client '" + asked.token.client + "' changes parameters or reloads too often; wait a moment");
}

/// Limits an observer's questions: they cost work of a scene's thread or of this one.
std::optional<Refused> ControlService::refuse_curious(const PendingRequest& asked) {
  if (covers(asked.token.role, Role::admin) || looks_.take(asked.token.client, monotonic_now()))
    return std::nullopt;
  return refuse(RefusalCode::too_many,
                "client '" + asked.token.client +
                    "' asks for descriptions and lists too often; ask twice a second at most");
}

/// Limits all requests, so that no client keeps this thread busy.
std::optional<Refused> ControlService::refuse_endless(const std::string& client) {
  if (requests_.take(client, monotonic_now())) return std::nullopt;
  return refuse(RefusalCode::too_many,
                "client '" + client + "' asks too often; wait a moment between requests");
}

control::Message ControlService::list_scenes(const Token& token) const {
  control::SceneList result;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    const SceneHost& host = *hosts_[i];
    if (!opens(token, host.name())) continue;
    result.scenes.push_back(
        {host.name(), static_cast<std::uint16_t>(1 + i), host.objects(), host.sessions()});
  }
  return result;
}

void ControlService::look_after() {
  refresh_tokens();
  for (const auto& [id, seated] : seated_) {
    const Token* token = good_token(seated.token);
    if (token != nullptr && covers(token->role, seated.role) && opens(*token, scene_name(seated)))
      continue;
    spdlog::info("a session of client {} ends: its token {} is good no more",
                 visible(seated.client), seated.token);
    hosts_[seated.scene]->evict(id);
  }
}

void ControlService::forget(const std::vector<EndedSession>& sessions) {
  for (const EndedSession& ended : sessions) {
    const auto found = seated_.find(ended.id);
    if (found == seated_.end()) continue;
    const ListedSession& seated = found->second;
    try {
      spdlog::info("{} left scene {} after {:.1f} s: {}", seated.who, hosts_[seated.scene]->name(),
                   seconds(monotonic_now() - seated.since), text(ended.how));
      if (ended.how == SessionEnd::disturbing)
        disturbers_[{seated.client, seated.scene}] =
            monotonic_now() + ServiceLimits::kDisturberPause;
    } catch (const std::bad_alloc&) {
      // No memory to log it or to keep its client out; the client has left anyway.
    }
    seated_.erase(found);
  }
}

Refused ControlService::refuse(RefusalCode code, std::string reason) {
  if (code == RefusalCode::unauthenticated) ++counters_.unauthenticated;
  if (code == RefusalCode::forbidden) ++counters_.forbidden;
  if (code == RefusalCode::too_many) ++counters_.too_many;
  return {code, std::move(reason)};
}

const Token* ControlService::good_token(const std::string& id) const {
  const Token* token = find_token(tokens_.tokens(), id);
  return token != nullptr && !expired(*token, calendar_now()) ? token : nullptr;
}

void ControlService::refresh_tokens() {
  if (const auto wrong = tokens_.refresh())
    spdlog::error("{}; the tokens stay as they were", *wrong);
}

const std::string& ControlService::scene_name(const ListedSession& seated) const {
  return hosts_[seated.scene]->name();
}

std::size_t ControlService::scene_of(std::string_view name) const {
  const auto found = std::find_if(hosts_.begin(), hosts_.end(),
                                  [&](const auto& host) { return host->name() == name; });
  return static_cast<std::size_t>(found - hosts_.begin());
}

/// Returns 56 random bits; the low byte is the number of the scene.
std::uint64_t ControlService::new_session_id(std::size_t scene) {
  std::uint64_t bits = 0;
  while (bits == 0) bits = (std::uint64_t{random_()} << 32 | random_()) << 8;
  return bits | scene;
}

}  // namespace feltwire
