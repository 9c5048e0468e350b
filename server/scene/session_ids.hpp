#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "server/scene/id_map.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

/// Finds the session of a datagram by its id. It allocates only when it is constructed.
class SessionIds {
 public:
  explicit SessionIds(std::size_t most) : present_(most) {}

  /// Null if there is none.
  SessionSlot* find(std::uint64_t id) noexcept {
    SessionSlot** const slot = present_.find(id);
    return slot == nullptr ? nullptr : *slot;
  }
  /// False if the id is 0 or already used, or there are too many.
  bool insert(SessionSlot& slot) noexcept { return present_.insert(slot.id, &slot); }
  void erase(std::uint64_t id) noexcept {
    present_.erase(id);
    ended_[next_++ % ended_.size()] = id;
  }
  /// Whether it is one of the sessions that ended last.
  bool has_just_ended(std::uint64_t id) const noexcept {
    return std::find(ended_.begin(), ended_.end(), id) != ended_.end();
  }

 private:
  IdMap<SessionSlot*> present_;
  std::array<std::uint64_t, 64> ended_{};
  std::size_t next_ = 0;
};

}  // namespace feltwire
