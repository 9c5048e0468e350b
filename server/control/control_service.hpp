#pragma once
// Answers control requests: checks tokens, roles and limits. It runs on the control thread.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "server/access/rate_limit.hpp"
#include "server/access/token_file.hpp"
#include "server/access/wrong_tokens.hpp"
#include "server/control/control_endpoint.hpp"
#include "server/scene/scene_host.hpp"

namespace feltwire {

struct ServiceLimits {
  std::size_t sessions_per_client = 16;
  std::size_t pointers = 4;  // sessions of role pointer, of all clients together
  /// [1/s] sustained, and at once: joins, changes of parameters and reloads, an observer's
  /// descriptions and lists of scenes, each for all tokens with one client's name; wrong tokens,
  /// for one network.
  double join_rate = 20.0, join_burst = 60.0;
  /// [1/s] sustained, and at once: all requests of one client's name that have no other limit.
  double request_rate = 200.0, request_burst = 1000.0;
  /// [1/s] sustained, and at once: parts and lists of what a session's client fetches in full. The
  /// most that an honest one asks for at once is some 750 (docs/limits.md).
  double fetch_rate = 100.0, fetch_burst = 2000.0;
  /// A client whose hand broke the simulation of a scene again and again (SessionEnd::disturbing)
  /// can join that scene with no hand for this time.
  static constexpr std::chrono::seconds kDisturberPause{60};
};

struct ServiceCounters {
  std::uint64_t unauthenticated = 0;  // requests without a valid token
  std::uint64_t forbidden = 0;        // beyond the token's role or scene
  std::uint64_t too_many = 0;         // above a limit
};

/// Both with their names in the summary.
std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(
    const ControlCounters& connections, const ServiceCounters& requests);

class ControlService {
 public:
  using Hosts = std::vector<std::unique_ptr<SceneHost>>;
  using Answer = std::function<void(control::Message)>;
  /// The error of a reload; empty: it succeeded.
  using Reloaded = std::function<void(std::optional<control::Refused> refused)>;
  /// Reloads a host's scene, or keeps the old one. It takes its time; `done` is called on the
  /// control thread.
  using Reload = std::function<void(std::size_t host, Reloaded done)>;

  /// Writes the flight record of a host's scene; `done` is called with its name on the control
  /// thread.
  using FlightWritten = std::function<void(std::variant<std::string, control::Refused> outcome)>;
  using WriteFlight = std::function<void(std::size_t host, FlightWritten done)>;

  /// `io` runs on the control thread; it and the hosts outlive this.
  /// `connections` counts those of the control port, on its thread; empty: all zero.
  /// `write_flight`: empty: there is no flight recorder.
  ControlService(asio::io_context& io, Hosts& hosts, TokenFile tokens, const ServiceLimits& limits,
                 Reload reload, std::function<ControlCounters()> connections = {},
                 WriteFlight write_flight = {});

  /// A ControlHandler.
  void handle(ControlPeer& peer, control::Message request, Answer answer);

  /// Call it once a second. It reads changed tokens again, and evicts the sessions of tokens that
  /// are revoked or have expired.
  void look_after();

  /// Takes the sessions that the hosts report as ended.
  void forget(const std::vector<EndedSession>& sessions);

  const ServiceCounters& counters() const { return counters_; }

 private:
  /// A session, from its request on.
  struct ListedSession {
    std::string token, client;  // the token's id, and its holder's name
    std::string tool;           // as the client asked for it; empty: the first
    std::size_t scene = 0;
    Role role = Role::observer;
    std::string who;               // for the log
    Nanoseconds since{0};          // time of the server's clock
    SessionParameters parameters;  // in force
    TokenBucket fetches;           // requests for surfaces and solids
  };
  struct PendingRequest;  // a request and its sender
  using Directory = std::map<std::uint64_t, ListedSession>;

  control::Message authenticate(ControlPeer& peer, const control::Authenticate& shown);
  void join(PendingRequest asked, control::JoinRequest request);
  void pass_on(PendingRequest asked, std::uint64_t session, control::Message request);
  void tell_of(const control::ParametersSet& set, const SessionParameters& wanted,
               const std::string& by);
  control::Message evict(const PendingRequest& asked, const control::Evict& request);
  control::Message list_scenes(const Token& token) const;
  bool serve_surfaces(PendingRequest& asked, control::Message& request);
  control::Message fetch(const PendingRequest& asked, std::uint64_t session,
                         const control::Message& request);
  ListedSession* own_session(const PendingRequest& asked, std::uint64_t id);
  control::Message list_sessions(const PendingRequest& asked, const control::ListSessions& request);
  void reload(PendingRequest asked, const control::ReloadScene& request);
  bool serve_observer(PendingRequest& asked, const control::Message& request);
  bool serve_admin(PendingRequest& asked, const control::Message& request);
  std::variant<std::size_t, control::Refused> scene_for(const PendingRequest& asked,
                                                        const std::string& name, Role role);
  void change(PendingRequest asked, const std::string& name, LiveChange change);
  void change_session(PendingRequest asked, std::uint64_t session, LiveChange change);
  void ask_scene(PendingRequest asked, const std::string& name, control::Message request);
  void write_flight(PendingRequest asked, const control::WriteFlightRecord& request);
  void count(PendingRequest asked, const control::GetCounters& request);
  control::Refused refuse(control::RefusalCode code, std::string reason);
  std::optional<control::Refused> refuse_below(Role role, const PendingRequest& asked);
  std::optional<control::Refused> refuse_hasty(const PendingRequest& asked);
  std::optional<control::Refused> refuse_curious(const PendingRequest& asked);
  std::optional<control::Refused> refuse_endless(const std::string& client);
  std::optional<control::Refused> refuse_join(const PendingRequest& asked,
                                              const control::JoinRequest& request);
  std::optional<control::Refused> refuse_pointer(const control::JoinRequest& request);
  const Token* good_token(const std::string& id) const;
  void refresh_tokens();
  const std::string& scene_name(const ListedSession& seated) const;
  std::size_t scene_of(std::string_view name) const;
  std::uint64_t new_session_id(std::size_t scene);

  asio::io_context& io_;
  Hosts& hosts_;
  TokenFile tokens_;
  ServiceLimits limits_;
  WrongTokens wrong_tokens_;
  RateLimit<std::string> joins_, changes_, looks_, requests_;  // by client
  RateLimit<std::string> refused_lines_{1.0,
                                        20.0};  // by client, for the log: joins refused at once
  Reload reload_;
  std::function<ControlCounters()> connections_;
  WriteFlight write_flight_;
  Directory seated_;
  // Until when a client's hands may not enter a scene whose simulation they broke.
  std::map<std::pair<std::string, std::size_t>, Nanoseconds> disturbers_;
  ServiceCounters counters_;
  std::random_device random_;  // of the operating system
};

}  // namespace feltwire
