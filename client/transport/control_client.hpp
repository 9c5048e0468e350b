#pragma once
// Sets up a session: control messages over TLS, and the address for its datagrams.

#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "client/transport/credentials.hpp"
#include "protocol/crypto/session_keys.hpp"
#include "protocol/fleet/epoch.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// A session could not be set up; what() gives the reason, in one line for people.
class SessionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An error that stays when the client asks again: the token, role, scene, tool, device or
/// parameters are refused, a certificate of either end is not valid, or the server's grant is not
/// allowed (protocol/session/grant.hpp). A server that is full, limits its clients or is away is
/// not such an error.
class LastingError : public SessionError {
 public:
  using SessionError::SessionError;
};

/// The server could not be reached, or did not answer in time.
class NoAnswer : public SessionError {
 public:
  using SessionError::SessionError;
};

struct Endpoint {
  std::string host;  // a name, an IPv4 or an IPv6 address
  std::uint16_t port = 0;

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// Reads HOST:PORT or [IPV6]:PORT. Throws std::invalid_argument.
Endpoint parse_endpoint(std::string_view text);
std::string to_string(const Endpoint& endpoint);

/// A server, and the credentials to use with it.
struct ServerAccess {
  Endpoint endpoint;
  Credentials credentials;
};

/// The server at HOST:PORT with the credentials in the environment: FELTWIRE_FINGERPRINT,
/// FELTWIRE_FINGERPRINT_FILE or FELTWIRE_CA; FELTWIRE_TOKEN_FILE or FELTWIRE_TOKEN;
/// FELTWIRE_CERTIFICATE and FELTWIRE_KEY. Throws std::invalid_argument that names the missing one.
ServerAccess access_from_environment(std::string_view server);

/// An address in the form of sockets.
struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
};

struct Joined {
  control::JoinAccepted accepted;         // without its secrets
  Address datagrams;                      // the scene's UDP port at the host that answered
  SessionKeys keys;                       // of the datagrams
  ServerAccess host = {};                 // that took the session; every further request goes there
  std::vector<ServerAccess> others = {};  // hosts of its fleet, to ask if it is silent
};

/// Asks the server for a session, and follows redirects to other hosts of its fleet
/// (FleetRoute). Blocks, at most `timeout` for each of connecting, TLS and the
/// answer. Sends the ciphers of this machine instead of those in `request`. Throws
/// SessionError if the host is not known, not reachable or not trusted, if the server refuses
/// (with its reason), and if its answer makes no sense or grants another session than the
/// requested one (forbidden_grant()).
Joined join(const ServerAccess& server, const control::JoinRequest& request,
            std::chrono::milliseconds timeout, const GrantLimits& limits = {});

/// Another host serves the scene.
struct Redirection {
  ServerAccess host;  // trusted by the fingerprint that the server has named
  std::string ticket;
  Epoch epoch;
};

/// As join(), of this server alone. Takes no session at an epoch below that in `request`, and no
/// host that the server may not name (forbidden_host()). Throws NoAnswer if there is none.
std::variant<Joined, Redirection> ask_to_join(const ServerAccess& server,
                                              const control::JoinRequest& request,
                                              std::chrono::milliseconds timeout,
                                              const GrantLimits& limits);

/// The scenes that the server has for this token. Blocks and throws as join() does.
std::vector<control::SceneEntry> list_scenes(const ServerAccess& server,
                                             std::chrono::milliseconds timeout);

/// Sends any other request and returns the answer. Blocks and throws as join() does.
control::Message ask(const ServerAccess& server, const control::Message& request,
                     std::chrono::milliseconds timeout);

}  // namespace feltwire
