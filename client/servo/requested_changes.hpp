#pragma once
// The changes that an admin requests of a session, as the servo loop takes and answers them.

#include <cstdint>
#include <optional>

#include "client/servo/prepared_change.hpp"
#include "core/base/ring.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

/// Numbers the sessions, hears each requested change once, and tells the server which one was
/// answered last. For the servo thread; nothing here allocates or throws.
class RequestedChanges {
 public:
  /// Another session follows. It counts its changes from 1 if it is fresh (begin_anew()).
  void next_session() noexcept { ++session_; }
  void begin_anew() noexcept { heard_ = answered_ = 0; }

  /// Queues a requested change once. Replies repeat the request until the server has the answer.
  void hear(const std::optional<ClientChange>& wanted, Ring<WantedChange>& queue) noexcept {
    if (!wanted || wanted->number == heard_) return;
    if (queue.push({*wanted, session_})) heard_ = wanted->number;
  }
  /// Takes a change as answered. Returns whether the present server knows of it.
  bool answered(const PreparedChange& change) noexcept {
    if (change.session != session_) return false;
    answered_ = change.number;
    refused_ = change.refused;
    return true;
  }
  void tell(HandReport& report) const noexcept {
    report.change = answered_;
    report.change_refused = refused_;
  }

 private:
  std::uint8_t heard_ = 0, answered_ = 0;  // numbers of the newest changes
  bool refused_ = false;                   // whether the newest answered change was refused
  std::uint32_t session_ = 0;              // number of the session, as in WantedChange
};

}  // namespace feltwire
