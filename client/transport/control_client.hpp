#pragma once
// Setting a session up: the control messages over TLS, and where its datagrams go.

#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "client/transport/credentials.hpp"
#include "protocol/crypto/session_keys.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// A session could not be set up; what() says why, in one line for people.
class SessionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One that asking again would not mend: the token, the role, the scene, the tool, the device or
/// the parameters are refused, one end's certificate is not good, or the server grants what it may
/// not (protocol/session/grant.hpp). What is full, limited or away may be there again.
class LastingError : public SessionError {
 public:
  using SessionError::SessionError;
};

struct Endpoint {
  std::string host;  // a name, an IPv4 or an IPv6 address
  std::uint16_t port = 0;
};

/// Reads HOST:PORT or [IPV6]:PORT. Throws std::invalid_argument.
Endpoint parse_endpoint(std::string_view text);
std::string to_string(const Endpoint& endpoint);

/// A server, and how it lets a client in.
struct ServerAccess {
  Endpoint endpoint;
  Credentials credentials;
};

/// The server at HOST:PORT with the credentials that the environment names: FELTWIRE_FINGERPRINT,
/// FELTWIRE_FINGERPRINT_FILE or FELTWIRE_CA; FELTWIRE_TOKEN_FILE or FELTWIRE_TOKEN;
/// FELTWIRE_CERTIFICATE and FELTWIRE_KEY. Throws std::invalid_argument naming what is missing.
ServerAccess access_from_environment(std::string_view server);

/// An address as the sockets take it.
struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
};

struct Joined {
  control::JoinAccepted accepted;
  Address datagrams;  // the scene's UDP port at the host that answered
  SessionKeys keys;   // of the datagrams
};

/// Asks the server for a session and waits at most `timeout` for each of connecting, TLS and
/// answering. Which ciphers this machine has is said here, whatever `request` says. Blocks; throws
/// SessionError: the host is not known or not reachable, it is not the one to be trusted, it
/// refuses (with its reason), its answer makes no sense, or it grants another session than the one
/// that was asked for.
Joined join(const ServerAccess& server, const control::JoinRequest& request,
            std::chrono::milliseconds timeout);

/// The scenes that the server has for this token. Likewise.
std::vector<control::SceneEntry> list_scenes(const ServerAccess& server,
                                             std::chrono::milliseconds timeout);

/// Any other request and its answer; a refusal throws. Likewise.
control::Message ask(const ServerAccess& server, const control::Message& request,
                     std::chrono::milliseconds timeout);

}  // namespace feltwire
