#include "server/fleet/ownership.hpp"

#include <algorithm>
#include <cassert>

namespace feltwire {
namespace {

/// The host's own record, changed: a new version that no other record has.
SceneRecord own_record(SceneOwnership& scene, const Epoch& epoch, const HostName& self,
                       const HostName& standby, const SceneDigest& digest) {
  return {self, {epoch, ++scene.changes}, standby, digest};
}

}  // namespace

bool see_epoch(SceneOwnership& scene, const Epoch& seen) {
  if (!admit(scene.highest, seen) || !scene.serving || *scene.serving >= seen) return false;
  scene.serving.reset();
  return true;
}

bool see_record(SceneOwnership& scene, const SceneRecord& record, std::uint64_t revision) {
  scene.stored = record.version;
  scene.revision = revision;
  // A damaged record is replaced by the next claim.
  if (!possible(record.version.epoch)) return false;
  // While it serves, its own record is the newest of its epoch.
  if (record.version > scene.record.version) scene.record = record;
  return see_epoch(scene, record.version.epoch);
}

SceneRecord claim(SceneOwnership& scene, const HostName& self, const SceneDigest& digest) {
  assert(!scene.serving);
  const Epoch tried{std::max(scene.highest.term, scene.last_term), 0};
  const Epoch epoch = next_epoch(tried, self.number);
  scene.last_term = epoch.term;
  return own_record(scene, epoch, self, {}, digest);
}

bool finish_claim(SceneOwnership& scene, const SceneRecord& claimed, std::uint64_t revision) {
  const Epoch& epoch = claimed.version.epoch;
  see_record(scene, claimed, revision);
  if (!possible(epoch) || epoch < scene.highest) return false;
  scene.serving = epoch;
  return true;
}

void reserve_standby(SceneOwnership& scene, const HostName& standby) {
  assert(scene.serving);
  scene.record =
      own_record(scene, *scene.serving, scene.record.owner, standby, scene.record.digest);
}

bool take_over(SceneOwnership& scene, const HostName& self) {
  if (scene.serving || scene.record.standby.number != self.number) return false;
  const Epoch epoch = reserved_epoch(scene.record);
  if (!admit(scene.highest, epoch)) return false;
  scene.serving = epoch;
  scene.last_term = std::max(scene.last_term, epoch.term);
  scene.record = own_record(scene, epoch, self, {}, scene.record.digest);
  return true;
}

std::optional<SceneRecord> record_to_write(const SceneOwnership& scene) {
  if (!scene.serving || scene.stored == scene.record.version) return std::nullopt;
  return scene.record;
}

void finish_write(SceneOwnership& scene, const SceneRecord& written, std::uint64_t revision) {
  see_record(scene, written, revision);
}

JoinAnswer answer_join(const SceneOwnership& scene, const Epoch& client_highest) {
  if (scene.serving && *scene.serving >= client_highest) return JoinAnswer::accepted;
  const Epoch& owner = scene.record.version.epoch;
  const bool elsewhere = !scene.serving && owner.holder != 0 && owner >= scene.highest;
  return elsewhere && owner >= client_highest ? JoinAnswer::redirected : JoinAnswer::unknown;
}

}  // namespace feltwire
