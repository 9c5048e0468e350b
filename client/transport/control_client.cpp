#include "client/transport/control_client.hpp"

#include <algorithm>
#include <array>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>
#include <variant>

#include "client/transport/control_dialogue.hpp"
#include "client/transport/fleet_route.hpp"
#include "client/transport/redirect_scope.hpp"
#include "protocol/net/ports.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/wire/session_secrets.hpp"

namespace feltwire {
namespace {

bool unit(const Vec3& direction) {
  return std::abs(direction.squaredNorm() - 1.0) <= kUnitTolerance;  // false for NaN
}

bool longer_hold(const SessionParameters& asked, const SessionParameters& granted) {
  return granted.hold_time > asked.hold_time;
}

/// Compares the granted session with the requested session, because a server must not be able to
/// remove the force bound. Returns a text that names the wrong field, or nothing.
std::optional<std::string> broken_offer(const control::JoinAccepted& offered,
                                        const control::JoinRequest& wanted,
                                        const GrantLimits& limits) {
  try {
    validate(offered.parameters);
  } catch (const std::invalid_argument& error) {
    return "parameters that cannot be: " + std::string(error.what());
  }
  if (const auto changed = forbidden_grant(wanted.parameters, offered.parameters, limits))
    return "other parameters than a server may: " + *changed +
           (longer_hold(wanted.parameters, offered.parameters)
                ? " (feltwire-client --longest-hold-time lets a server lengthen it)"
                : "");
  // Each comparison is false for NaN.
  if (!(offered.silence_timeout >= control::kShortestSilence &&
        offered.silence_timeout <= control::kLongestSilence))
    return "a silence_timeout that is not within 0.1 to 3600 s";
  if (!(offered.start_position.cwiseAbs().maxCoeff() <= kMaxPosition) ||
      !offered.start_position.allFinite())
    return "a start_position beyond 1000 m";
  if (!unit(offered.start_normal)) return "a start_normal that is not of length one";
  if (!(offered.stiffness >= 0.0 && offered.stiffness <= kStiffest))
    return "a stiffness that is not within 0 to 1e9 N/m";
  return std::nullopt;
}

Address address_of(const asio::ip::udp::endpoint& endpoint) {
  Address address;
  address.size = static_cast<socklen_t>(endpoint.size());
  std::memcpy(&address.storage, endpoint.data(), endpoint.size());
  return address;
}

/// The access to a host that a server has named. The client knows the host by the fingerprint that
/// came over TLS from the server, which it trusts already; authorities say nothing about a host.
ServerAccess named_host(const ServerAccess& by, const control::FleetHost& host) {
  ServerAccess named{{host.address, host.port}, by.credentials};
  named.credentials.trust = host.fingerprint;
  return named;
}

Redirection followed(const ControlDialogue& dialogue, const ServerAccess& server,
                     control::Redirected&& said, const Epoch& seen) {
  if (const auto wrong = forbidden_host(dialogue.stream().peer(), said.host))
    dialogue.refuse("sends this client to " + *wrong);
  if (said.epoch < seen)
    throw SessionError(to_string(server.endpoint) +
                       " knows an earlier owner of the scene than this client; try again");
  return {named_host(server, said.host), std::move(said.ticket), said.epoch};
}

/// Ends a session that the client does not take.
void leave(ControlDialogue& dialogue, std::uint64_t session) {
  try {
    dialogue.ask(control::LeaveRequest{session});
  } catch (const SessionError&) {  // the server's silence timeout ends it
  }
}

}  // namespace

Endpoint parse_endpoint(std::string_view text) {
  const auto fail = [&](const char* what) {
    const std::string port = std::to_string(kDefaultPort);
    throw std::invalid_argument("'" + std::string(text) + "' " + what +
                                "; write HOST:PORT, e.g. localhost:" + port + " or [::1]:" + port);
  };
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) fail("has no port");
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    fail("is an IPv6 address without brackets");
  }
  if (host.empty()) fail("has no host");
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || rest != digits.data() + digits.size() || port == 0)
    fail("has no port from 1 to 65535");
  return {std::string(host), port};
}

std::string to_string(const Endpoint& endpoint) {
  return host_and_port(endpoint.host, endpoint.port);
}

Joined join(const ServerAccess& server, const control::JoinRequest& request,
            std::chrono::milliseconds timeout, const GrantLimits& limits) {
  return FleetRoute(server).join(request, timeout, limits);
}

std::variant<Joined, Redirection> ask_to_join(const ServerAccess& server,
                                              const control::JoinRequest& request,
                                              std::chrono::milliseconds timeout,
                                              const GrantLimits& limits) {
  control::JoinRequest wanted = request;
  wanted.aes_256_gcm = has_aes_256_gcm();
  ControlDialogue dialogue(server, timeout);
  control::Message answer = dialogue.ask(wanted);
  if (auto* redirected = std::get_if<control::Redirected>(&answer))
    return followed(dialogue, server, std::move(*redirected), wanted.epoch);
  auto* accepted = std::get_if<control::JoinAccepted>(&answer);
  if (accepted == nullptr || accepted->session == 0 || accepted->port_offset == 0)
    dialogue.bad_answer();
  const std::string name = to_string(server.endpoint);
  constexpr unsigned kLastPort = 65535;
  const unsigned port = unsigned{server.endpoint.port} + accepted->port_offset;
  if (port > kLastPort)
    throw SessionError(name + ": the scene's port would be " + std::to_string(port) +
                       ", which is none; have the server listen on a lower port");
  if (accepted->suite == CipherSuite::aes_256_gcm && !wanted.aes_256_gcm)
    throw LastingError(name + " chose a cipher that this machine does not have");
  if (!wanted.tool.empty() && accepted->tool != wanted.tool)
    throw LastingError(name + " knows of no tools to choose from; join without naming one");
  if (const auto broken = broken_offer(*accepted, wanted, limits))
    throw LastingError(name + " granted " + *broken +
                       "; this client joins no such session: is it a server to be trusted?");
  if (accepted->epoch < wanted.epoch) {
    leave(dialogue, accepted->session);
    throw SessionError(name +
                       " has served the scene before another host did, and does not know it yet; "
                       "try again, or start anew if the server has left its fleet");
  }
  const auto peer = dialogue.stream().peer();
  std::vector<ServerAccess> others;
  for (const control::FleetHost& other : accepted->hosts)
    if (!forbidden_host(peer, other)) others.push_back(named_host(server, other));
  const Address datagrams = address_of({peer, static_cast<std::uint16_t>(port)});
  try {
    const SessionKeys keys = take_keys(*accepted);
    return Joined{std::move(*accepted), datagrams, keys, server, std::move(others)};
  } catch (const std::invalid_argument& error) {
    throw LastingError(name + " gave the session no good secrets: " + error.what());
  }
}

std::vector<control::SceneEntry> list_scenes(const ServerAccess& server,
                                             std::chrono::milliseconds timeout) {
  ControlDialogue dialogue(server, timeout);
  control::Message answer = dialogue.ask(control::ListScenes{});
  auto* list = std::get_if<control::SceneList>(&answer);
  if (list == nullptr) dialogue.bad_answer();
  if (list->scenes.size() > control::kMaxScenes)
    dialogue.refuse("listed " + std::to_string(list->scenes.size()) +
                    " scenes, more than a server can have");
  return std::move(list->scenes);
}

control::Message ask(const ServerAccess& server, const control::Message& request,
                     std::chrono::milliseconds timeout) {
  return ControlDialogue(server, timeout).ask(request);
}

}  // namespace feltwire
