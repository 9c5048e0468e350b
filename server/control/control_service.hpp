#pragma once
// Answers control requests: checks tokens, roles and limits. It runs on the control thread.

#include <asio/io_context.hpp>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "server/access/rate_limit.hpp"
#include "server/access/token_file.hpp"
#include "server/access/wrong_tokens.hpp"
#include "server/control/admin_service.hpp"
#include "server/control/control_endpoint.hpp"
#include "server/control/pending_request.hpp"
#include "server/control/request_limits.hpp"
#include "server/control/scene_hosts.hpp"
#include "server/control/session_directory.hpp"
#include "server/fleet_host/fleet_member.hpp"

namespace feltwire {

/// Knows the sender of each request by its token, and answers it or passes it on to the scene's
/// thread. Owns the tokens, the list of sessions and the limits.
class ControlService {
 public:
  /// `io` runs on the control thread; it and the hosts outlive this.
  ControlService(asio::io_context& io, SceneHosts& hosts, TokenFile tokens,
                 const ServiceLimits& limits, AdminService::Callbacks callbacks);

  /// The server is a host of this fleet, which outlives this. Call it before the first request.
  void join_fleet(FleetMember& fleet) { fleet_ = &fleet; }

  /// A ControlHandler.
  void handle(ControlPeer& peer, control::Message request, ControlAnswer answer);

  /// Call it once a second. It reads changed tokens again, evicts the sessions of tokens that are
  /// revoked or have expired, and frees what belongs to scenes that were loaded again.
  void look_after();

  /// Ends the sessions of scenes that other hosts of the fleet serve now.
  void end_sessions(const std::vector<std::string>& scenes);

  /// Takes the sessions that the hosts report as ended.
  void forget(const std::vector<EndedSession>& sessions);

  const ServiceCounters& counters() const { return request_limits_.counters(); }

 private:
  control::Message authenticate(ControlPeer& peer, const control::Authenticate& shown);
  void join(PendingRequest asked, control::JoinRequest request);
  std::optional<control::Refused> refuse_token(const Token& token,
                                               const control::JoinRequest& request);
  std::optional<control::Refused> refuse_join(const Token& token,
                                              const control::JoinRequest& request);
  FleetMember::Answer ask_fleet(const PendingRequest& asked, const control::JoinRequest& request);
  std::optional<control::Refused> refuse_elsewhere(const control::Message& request);
  void refuse(PendingRequest& asked, const control::JoinRequest& request, const std::string& who,
              const control::Refused& refused);
  std::optional<control::Refused> refuse_pointer(const control::JoinRequest& request);
  void change_session(PendingRequest asked, std::uint64_t session, control::Message request);
  void pass_on(PendingRequest asked, std::uint64_t session, control::Message request);
  control::Message fetch(const Token& token, std::uint64_t session,
                         const control::Message& request);
  void tell_of(const control::ParametersSet& set, const SessionParameters& wanted,
               const std::string& by);
  control::Message list_scenes(const Token& token) const;
  const Token* good_token(const std::string& id) const;
  void refresh_tokens();
  std::uint64_t new_session_id(std::size_t scene);

  asio::io_context& io_;
  SceneHosts& hosts_;
  TokenFile tokens_;
  ServiceLimits limits_;
  WrongTokens wrong_tokens_;
  RequestLimits request_limits_;
  RateLimit<std::string> refused_lines_{1.0, 20.0};  // by client, for the log: joins refused
  SessionDirectory directory_;
  AdminService admins_;
  FleetMember* fleet_ = nullptr;  // null: the server is in no fleet
  std::random_device random_;     // of the operating system
};

}  // namespace feltwire
