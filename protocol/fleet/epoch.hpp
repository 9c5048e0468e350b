#pragma once
// The epoch of a scene: which host process may take its joins, and which one came later.
//
// An epoch names its holder, as a ballot number does (L. Lamport: Paxos made simple, 2001). Two
// processes can therefore never hold the same epoch, even if a directory has lost the writes that
// told them of each other.

#include <cstdint>

namespace feltwire {

/// The number of a host process: drawn at random at each start and never 0. A process that starts
/// again has another number, because it remembers no epoch.
using HostNumber = std::uint64_t;

/// A turn of one host process as the owner of a scene. Later epochs are greater.
struct Epoch {
  std::uint64_t term = 0;  // 0: nobody has owned the scene yet
  HostNumber holder = 0;   // the only process that takes joins at this epoch

  friend bool operator==(const Epoch&, const Epoch&) = default;
  friend constexpr bool operator<(const Epoch& a, const Epoch& b) noexcept {
    return a.term != b.term ? a.term < b.term : a.holder < b.holder;
  }
  friend constexpr bool operator>(const Epoch& a, const Epoch& b) noexcept { return b < a; }
  friend constexpr bool operator<=(const Epoch& a, const Epoch& b) noexcept { return !(b < a); }
  friend constexpr bool operator>=(const Epoch& a, const Epoch& b) noexcept { return !(a < b); }
};

/// No fleet comes to a later term. An epoch beyond it is damaged or forged: the terms after it
/// would begin at 0 again, and two claims would have the same epoch.
inline constexpr std::uint64_t kMostTerm = std::uint64_t{1} << 62;
constexpr bool possible(const Epoch& epoch) noexcept { return epoch.term <= kMostTerm; }

/// The epoch of this holder in the term after `highest`, whoever holds that.
constexpr Epoch next_epoch(const Epoch& highest, HostNumber holder) noexcept {
  return {highest.term + 1, holder};
}

/// Raises `highest` to `offered`. Returns false, and changes nothing, if `offered` is lower, and so
/// of a former owner, or is not possible: the offer must be refused.
constexpr bool admit(Epoch& highest, const Epoch& offered) noexcept {
  if (offered < highest || !possible(offered)) return false;
  highest = offered;
  return true;
}

}  // namespace feltwire
