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

  /// How many changes are judged and kept while the client runs; those after them are refused.
  static constexpr std::size_t kMost = 256;

  /// The rings of the servo loop: LoopOutputs::wanted and LoopOptions::changes.
  Ring<WantedChange>& wanted() { return wanted_; }
  Ring<PreparedChange*>& ready() { return ready_; }

  /// Deals with the next change that has come; null: none has. What it returns stays until the next
  /// call. Where there is no memory for it, and after kMost, the change is refused.
  /// `session`: WantedChange::session of the newest session that the loop was given; what an older
  /// one wanted is passed over, because the newest was joined without it.
  const Done* next(std::uint32_t session) noexcept;
  /// The first kMost so far. Those that the servo has not taken have no time. Once the servo's
  /// thread has ended.
  const std::deque<Done>& done() const { return done_; }
  /// In force after all that were taken.
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
  // Of changes that are not kept. The servo's thread has the addresses of at most kRoom that wait
  // and of one that it looks at, so the place after those is free.
  std::array<Done, kRoom + 2> not_kept_;
  std::size_t next_not_kept_ = 0;
  std::deque<Done> done_;  // they stay where they are: the servo's thread has their addresses
};

}  // namespace feltwire
