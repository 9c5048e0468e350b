#pragma once
// The changes that admins want of a running client: judged, made ready, told to the user.

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
  /// One that was dealt with, for the log, the recording and the report.
  struct Done {
    PreparedChange prepared;
    std::string what;     // for people: from what to what
    std::string refusal;  // why it was refused; empty: it was taken
  };

  /// What the client refers to must outlive this. Copies what the servo's thread may change.
  explicit Changes(const Client& client);

  /// The rings of the servo loop: LoopOutputs::wanted and LoopOptions::changes.
  Ring<ClientChange>& wanted() { return wanted_; }
  Ring<PreparedChange*>& ready() { return ready_; }

  /// Deals with the next change that has come; null: none has. What it returns stays. Where there
  /// is no memory for it the change is refused.
  const Done* next() noexcept;
  /// All so far. Those that the servo has not taken have no time. Once the servo's thread has
  /// ended.
  const std::deque<Done>& done() const { return done_; }
  /// In force after all that were taken.
  LawChoice law() const { return law_of(now_); }

 private:
  Done judged(const ClientChange& change);

  static constexpr std::size_t kRoom = 16;
  DeviceSpec spec_;
  SessionParameters started_, now_;
  ServoOptions options_;
  const DatagramPort& port_;
  ChangesTaken takes_;
  Ring<ClientChange> wanted_{kRoom};
  Ring<PreparedChange*> ready_{kRoom};
  std::deque<Done> done_;  // they stay where they are: the servo's thread has their addresses
};

}  // namespace feltwire
