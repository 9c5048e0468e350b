#pragma once
// The changes that admins want of a running client: it checks and prepares them, and tells the
// user.

#include <array>
#include <deque>
#include <string>

#include "client/servo/prepared_change.hpp"
#include "client/transport/datagram_port.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// For the thread that attends the servo's. A change is made whole or refused whole.
class Changes {
 public:
  struct Client {
    const DeviceSpec& spec;
    const SessionParameters& started;  // of the session
    const ServoOptions& options;       // of its servo
    const DatagramPort& port;
    ChangesTaken takes;
  };
  /// A handled change, for the log, the recording and the report.
  struct Done {
    PreparedChange prepared;
    std::string what;     // for people: the old and the new value
    std::string refusal;  // the reason of the refusal; empty: it was taken
  };

  /// The client's references must outlive this. It copies the members that the servo's thread may
  /// change.
  explicit Changes(const Client& client);

  /// The largest number of changes that are judged and kept while the client runs; later ones are
  /// refused.
  static constexpr std::size_t kMost = 256;

  /// The rings of the servo loop: LoopOutputs::wanted and LoopOptions::changes.
  Ring<WantedChange>& wanted() { return wanted_; }
  Ring<PreparedChange*>& ready() { return ready_; }

  /// Handles the next change; null: there is none. The result is valid until the next call. If
  /// there is no memory for it, and after kMost, the change is refused. `session`:
  /// WantedChange::session of the newest session of the loop. A change of an older session is
  /// passed over, because the newest was joined without it.
  const Done* next(std::uint32_t session) noexcept;
  /// The first kMost so far. Those that the servo has not taken have no time. Call it after the
  /// servo's thread has ended.
  const std::deque<Done>& done() const { return done_; }
  /// The parameters in force after all taken changes.
  LawChoice law() const { return law_of(now_); }

 private:
  Done judged(const ClientChange& change);
  Done& refused(const char* why) noexcept;

  static constexpr std::size_t kRoom = 16;
  DeviceSpec spec_;
  SessionParameters started_, now_;
  ServoOptions options_;
  const DatagramPort& port_;
  ChangesTaken takes_;
  Ring<WantedChange> wanted_{kRoom};
  Ring<PreparedChange*> ready_{kRoom};
  // For changes that are not kept. The servo's thread has the addresses of at most kRoom waiting
  // ones and of one in use, so the place after those is free.
  std::array<Done, kRoom + 2> not_kept_;
  std::size_t next_not_kept_ = 0;
  std::deque<Done> done_;  // their addresses are stable, because the servo's thread has them
};

}  // namespace feltwire
