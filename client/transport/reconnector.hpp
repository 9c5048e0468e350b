#pragma once
// Joins again after a session was lost, while the servo loop continues.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "client/transport/background_work.hpp"
#include "client/transport/backoff.hpp"
#include "client/transport/control_client.hpp"
#include "client/transport/fleet_route.hpp"
#include "client/transport/transport.hpp"
#include "core/base/ring.hpp"
#include "protocol/session/client_change.hpp"

namespace feltwire {

/// The waits before attempts are those of a Backoff.
struct RejoinOptions {
  std::chrono::milliseconds first_wait{250}, longest_wait{4000};
  std::chrono::milliseconds timeout{1000};  // of each attempt
  /// The seats for robots that the new session must have, because the hand knows them by number;
  /// empty: it leads none.
  std::vector<std::string> seats{};
  std::uint64_t seed = random_seed();  // of the waits
};

/// For one thread other than the servo's. Attempts run in a thread of their own, so that look()
/// never blocks. An attempt that fails because memory, descriptors or threads are missing is
/// repeated like any other.
class Reconnector {
 public:
  using Clock = std::chrono::steady_clock;

  /// `request` must request the parameters in force, because the new session has to be the same.
  /// New sessions go to `out`.
  Reconnector(FleetRoute route, control::JoinRequest request, Ring<SessionAddress>& out,
              const RejoinOptions& options = {});

  /// Call it now and then. `connected`: whether the loop has a session.
  void look(bool connected, Clock::time_point now) noexcept;

  /// The law in force has changed: the next session must have it, too. A session from an attempt
  /// under way has the old law: it is left to the server's silence timeout.
  void put_law(const LawChoice& law) {
    request_.parameters = with_law(request_.parameters, law);
    outdated_ = attempt_.valid();
  }

  /// The reason why there will be no other session, in one line (LastingError); then the
  /// reconnector has stopped. Empty while there may be one.
  const std::string& refusal() const { return refusal_; }
  std::uint64_t attempts() const { return attempts_; }
  /// The number of the newest session that went to `out`; 0: none did.
  std::uint64_t session() const { return session_; }
  /// The number of sessions that went to `out`.
  std::uint32_t sessions() const { return sessions_; }
  /// The host of the newest session.
  const ServerAccess& host() const { return route_.host(); }
  /// Whether an attempt has begun whose outcome look() has not taken yet.
  bool asking() const { return attempt_.valid(); }

 private:
  FleetRoute route_;
  control::JoinRequest request_;
  Ring<SessionAddress>& out_;
  RejoinOptions options_;
  /// The result of an attempt.
  struct Attempt {
    std::optional<SessionAddress> session;  // empty: the server is away or full; try again
    std::string refusal;                    // else: why another attempt is useless
    std::optional<FleetRoute> route{};      // with what the attempt has learned
  };
  static Attempt attempt(FleetRoute& route, const control::JoinRequest& request,
                         const RejoinOptions& options);
  void begin();
  Attempt outcome() noexcept;

  BackgroundWork<Attempt> attempt_;
  std::string refusal_;
  bool outdated_ = false;     // the attempt under way requests an outdated law
  bool lost_ = false;         // the wait before the first attempt after a loss was drawn
  bool handed_over_ = false;  // the loop has not said yet that it took the new session
  Clock::time_point next_{}, handed_over_at_{};
  Backoff backoff_;
  std::uint64_t attempts_ = 0;
  std::uint32_t sessions_ = 0;
  std::uint64_t session_ = 0;
};

}  // namespace feltwire
