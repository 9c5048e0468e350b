#pragma once
// The ownership of a scene: what one host knows and does, as values and functions without a clock,
// a directory or a thread. The host calls them from one thread and carries out what they return.
//
// A host takes joins at one epoch at a time, which names it (protocol/fleet/epoch.hpp). It gets the
// epoch in one of two ways: it claims the scene by compare-and-swap and waits for the answer, or it
// is the standby, for which the owner's record reserves the next epoch, and waits for nothing. It
// lets go when it hears of a higher epoch, or hands the scene over to a host that it names its
// standby. tests/server/fleet/ownership_search_test.cpp tries all orders of these steps with a
// directory that lies.

#include <cstdint>
#include <optional>

#include "server/fleet/scene_record.hpp"

namespace feltwire {

/// The knowledge of a host about one scene, and whether it serves it.
struct SceneOwnership {
  Epoch highest;                 // ever seen
  std::optional<Epoch> serving;  // it takes joins at this epoch; never below `highest`
  // It has handed this epoch over: it takes no joins, and its sessions go on until it sees the next
  // owner. Never below `highest`, and never together with `serving`.
  std::optional<Epoch> leaving;
  SceneRecord record;  // the newest version that it knows; while it serves or leaves: its own
  // The directory's entry that came last, which may be an old one.
  RecordVersion stored;
  std::uint64_t revision = 0;   // of that entry, for the next compare-and-swap; 0: there was none
  std::uint64_t last_term = 0;  // that it has tried to claim
  std::uint64_t changes = 0;    // of records that it wrote

  friend bool operator==(const SceneOwnership&, const SceneOwnership&) = default;
};

/// An epoch was seen: in a record, or in a ticket that another host has signed. Never call it with
/// a number that only a client says: that would let any client take a scene from its owner. Returns
/// whether the host has lost the scene by it: its sessions get the goodbye `moved`.
bool see_epoch(SceneOwnership& scene, const Epoch& seen);

/// The directory has delivered an entry: by a watch or a list, in any order, also old ones and the
/// same twice. Returns whether the host has lost the scene by it.
bool see_record(SceneOwnership& scene, const SceneRecord& record, std::uint64_t revision);

/// Returns the record with which this host claims the scene, for a compare-and-swap against
/// `revision`. No two claims have the same epoch. Precondition: the host does not serve the scene.
SceneRecord claim(SceneOwnership& scene, const HostName& self, const SceneDigest& digest);

/// The directory has acknowledged a claim, with the revision of the new entry. Returns whether the
/// host serves the scene now; not if it has seen a higher epoch meanwhile. A claim whose answer is
/// missing or a conflict has no effect: see what the directory has, and claim again.
bool finish_claim(SceneOwnership& scene, const SceneRecord& claimed, std::uint64_t revision);

/// The owner names its standby, or none (number 0). The new record is to be written next.
/// Precondition: the host serves the scene.
void reserve_standby(SceneOwnership& scene, const HostName& standby);

/// The standby takes over, because the owner is silent. It serves from now on at the reserved
/// epoch; the directory is told afterwards. Returns false, and changes nothing, if the known record
/// names another standby or a higher epoch was seen.
bool take_over(SceneOwnership& scene, const HostName& self);

/// The owner hands the scene over to `target`, which becomes its standby. From now on it takes no
/// join; its sessions go on until it sees a later epoch. The new record is to be written next. If
/// the target does not take the scene, the former owner claims it again, at an epoch beyond the
/// target's. Precondition: the host serves the scene, and `target` is another process.
void hand_over(SceneOwnership& scene, const HostName& target);

/// Whether the known record hands the scene over to this host: it is to take over now.
bool is_handed_to(const SceneOwnership& scene, const HostName& self);

/// The record that an owner must write, by compare-and-swap against `revision`, until the directory
/// has it: a new standby, a takeover, a handover, or what a restored directory has forgotten.
/// Empty: nothing.
std::optional<SceneRecord> record_to_write(const SceneOwnership& scene);

/// The directory has acknowledged such a write.
void finish_write(SceneOwnership& scene, const SceneRecord& written, std::uint64_t revision);

enum class JoinAnswer {
  accepted,    // at `serving`
  redirected,  // to the owner of `record`
  unknown,     // the host knows no owner that is new enough for this client; try again or elsewhere
};

/// Answers a join of a client that has seen no epoch of the scene above `client_highest`.
JoinAnswer answer_join(const SceneOwnership& scene, const Epoch& client_highest);

}  // namespace feltwire
