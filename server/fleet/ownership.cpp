#include "server/fleet/ownership.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace feltwire {
namespace {

/// The host's own record, changed: a new version that no other record has.
SceneRecord own_record(SceneOwnership& scene, const Epoch& epoch, const HostName& self,
                       const HostName& standby, const SceneDigest& digest) {
  return {self, {epoch, ++scene.changes}, standby, digest, false};
}

}  // namespace

bool see_epoch(SceneOwnership& scene, const Epoch& seen) {
  if (!admit(scene.highest, seen)) return false;
  // A claim of this host itself, for what it has handed over, ends no session.
  const bool left = scene.leaving && *scene.leaving < seen && scene.leaving->holder != seen.holder;
  const bool taken = scene.serving && *scene.serving < seen;
  if (left) scene.leaving.reset();
  if (taken) scene.serving.reset();
  return left || taken;
}

bool see_record(SceneOwnership& scene, const SceneRecord& record, std::uint64_t revision) {
  scene.stored = record.version;
  scene.revision = revision;
  // A damaged record is replaced by the next claim.
  if (!possible(record.version.epoch)) return false;
  // While it serves or leaves, its own record is the newest of its epoch.
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
  scene.leaving.reset();
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

void hand_over(SceneOwnership& scene, const HostName& target) {
  reserve_standby(scene, target);
  scene.record.handed_over = true;
  scene.leaving = std::exchange(scene.serving, std::nullopt);
  scene.last_term = std::max(scene.last_term, reserved_epoch(scene.record).term);
}

bool is_handed_to(const SceneOwnership& scene, const HostName& self) {
  return scene.record.handed_over && scene.record.standby == self;
}

std::optional<SceneRecord> record_to_write(const SceneOwnership& scene) {
  const bool owns = scene.serving || scene.leaving;
  if (!owns || scene.stored == scene.record.version) return std::nullopt;
  return scene.record;
}

void finish_write(SceneOwnership& scene, const SceneRecord& written, std::uint64_t revision) {
  see_record(scene, written, revision);
}

JoinAnswer answer_join(const SceneOwnership& scene, const Epoch& client_highest) {
  if (scene.serving && *scene.serving >= client_highest) return JoinAnswer::accepted;
  const Epoch& owner = scene.record.version.epoch;
  const bool elsewhere =
      !scene.serving && !scene.record.handed_over && owner.holder != 0 && owner >= scene.highest;
  return elsewhere && owner >= client_highest ? JoinAnswer::redirected : JoinAnswer::unknown;
}

}  // namespace feltwire
