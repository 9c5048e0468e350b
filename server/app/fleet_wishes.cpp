#include "server/app/fleet_wishes.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "server/fleet/record_codec.hpp"
#include "server/fleet/wish.hpp"
#include "server/fleet_host/known_hosts.hpp"

namespace feltwire {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kForAnswer = 10s;  // of a host that lives, to a wish
constexpr Nanoseconds kForScenes = 30s;  // until they are at other hosts
constexpr std::chrono::milliseconds kBetweenLists{100};

template <class Record>
std::string names_of(const std::map<std::string, Record>& records) {
  std::string names;
  for (const auto& [name, record] : records) names += (names.empty() ? "" : ", ") + visible(name);
  return names.empty() ? "none" : names;
}

/// Looks again and again until it is done. Returns false if that takes longer than `patience`.
template <class Done>
bool wait_until(Nanoseconds patience, Done done) {
  const Nanoseconds end = monotonic_now() + patience;
  while (!done()) {
    if (monotonic_now() >= end) return false;
    std::this_thread::sleep_for(kBetweenLists);
  }
  return true;
}

/// Returns the record of that name. `kind`: "host" or "scene", for the error.
template <class Record>
Record known(const std::map<std::string, Record>& records, const std::string& kind,
             const std::string& name) {
  const auto found = records.find(name);
  if (found == records.end())
    throw std::invalid_argument("the fleet has no " + kind + " '" + visible(name) + "'; its " +
                                kind + "s: " + names_of(records));
  return found->second;
}

HostRecord known_host(Directory& directory, const std::string& name) {
  return known(host_records(directory), "host", name);
}

SceneRecord known_scene(Directory& directory, const std::string& name) {
  return known(scene_records(directory), "scene", name);
}

/// Returns the host's heartbeat once another one has come.
HostRecord living_host(Directory& directory, const std::string& name) {
  const HostRecord before = known_host(directory, name);
  HostRecord now = before;
  const bool lives = wait_until(kSilent, [&] {
    const auto hosts = host_records(directory);
    const auto found = hosts.find(name);
    if (found == hosts.end()) return false;
    now = found->second;
    return now.host != before.host || now.beat > before.beat;
  });
  if (lives) return now;
  throw std::runtime_error("host " + visible(name) +
                           " is silent; a standby takes its scenes over if it is gone");
}

/// Writes a wish to the host, with a number that the host has not read yet.
std::optional<std::uint64_t> write_wish(Directory& directory, Wish wish, std::uint64_t read) {
  std::uint64_t revision = 0;
  for (const DirectoryEntry& entry : entries_of(directory, Bucket::wishes)) {
    if (entry.key != wish.host.name) continue;
    revision = entry.revision;
    if (const auto before = decode_wish(entry.value)) read = std::max(read, before->serial);
  }
  wish.serial = read + 1;
  const WriteAnswer answer =
      directory.compare_and_swap(Bucket::wishes, wish.host.name, encode(wish), revision);
  if (answer.result != WriteResult::written) return std::nullopt;
  return wish.serial;
}

/// Tells the host the wish, and waits until it has read it. The directory may lose the wish, so it
/// is written again.
void tell_host(Directory& directory, const Wish& wish) {
  const std::string who = "host " + visible(wish.host.name);
  std::optional<std::uint64_t> serial;
  Nanoseconds again{0};
  HostRecord host;
  const bool answered = wait_until(kForAnswer, [&] {
    host = known_host(directory, wish.host.name);
    if (host.host != wish.host) throw std::runtime_error(who + " has started anew; ask it again");
    if (serial && host.wish == *serial) return true;
    if (serial && host.wish > *serial)
      throw std::runtime_error("another wish to " + who + " came between; see fleet status");
    if (monotonic_now() < again) return false;
    serial = write_wish(directory, wish, host.wish);
    again = monotonic_now() + (serial ? kBeat : Nanoseconds(0));
    return false;
  });
  if (!answered) throw std::runtime_error(who + " has not answered; see its log");
  if (!host.wish_refusal.empty())
    throw std::runtime_error(who + " does not do it: " + visible(host.wish_refusal));
}

}  // namespace

std::vector<DirectoryEntry> entries_of(Directory& directory, Bucket bucket) {
  auto entries = directory.list(bucket);
  if (!entries) throw std::runtime_error("the directory gives no answer; is a majority of it up?");
  return *std::move(entries);
}

std::map<std::string, HostRecord> host_records(Directory& directory) {
  std::map<std::string, HostRecord> hosts;
  for (const DirectoryEntry& entry : entries_of(directory, Bucket::hosts))
    if (auto record = decode_host_record(entry.value)) hosts.emplace(entry.key, *std::move(record));
  return hosts;
}

std::map<std::string, SceneRecord> scene_records(Directory& directory) {
  std::map<std::string, SceneRecord> scenes;
  for (const DirectoryEntry& entry : entries_of(directory, Bucket::scenes))
    if (const auto record = decode_scene_record(entry.value)) scenes.emplace(entry.key, *record);
  return scenes;
}

std::string drain_host(Directory& directory, const std::string& name) {
  const HostRecord host = living_host(directory, name);
  const std::string who = "host " + visible(name);
  if (host.draining) throw std::runtime_error(who + " drains already; see fleet status");
  tell_host(directory, {host.host, 0, WishKind::drain, {}, 0, {}});
  std::string kept;
  const bool empty = wait_until(kForScenes, [&] {
    const auto scenes = scene_records(directory);
    kept = known_host(directory, name).kept;
    const bool serves = std::ranges::any_of(
        scenes, [&](const auto& entry) { return entry.second.owner == host.host; });
    return !serves || !kept.empty();
  });
  if (!kept.empty()) throw std::runtime_error(who + " drains, and keeps " + visible(kept));
  if (!empty)
    throw std::runtime_error(who + " drains, and still has scenes; see fleet status and its log");
  return who + " drains, and serves no scene";
}

std::string undrain_host(Directory& directory, const std::string& name) {
  const HostRecord host = living_host(directory, name);
  const std::string who = "host " + visible(name);
  if (!host.draining) throw std::runtime_error(who + " does not drain");
  tell_host(directory, {host.host, 0, WishKind::undrain, {}, 0, {}});
  return who + " takes scenes again";
}

std::string move_scene(Directory& directory, const std::string& scene, const std::string& host) {
  const SceneRecord record = known_scene(directory, scene);
  const HostRecord target = living_host(directory, host);
  const std::string what = "scene " + visible(scene), who = "host " + visible(host);
  if (record.owner == target.host) throw std::runtime_error(who + " serves " + what + " already");
  if (target.draining)
    throw std::runtime_error(who + " drains, so it takes no scene; fleet undrain ends that");
  if (std::ranges::count(target.scenes, scene_tag(scene, record.digest)) == 0)
    throw std::runtime_error(who + " has no " + what +
                             " with the files of the host that serves it; give it the same files");
  const HostRecord owner = living_host(directory, record.owner.name);
  tell_host(directory,
            {owner.host, 0, WishKind::move, scene, record.version.epoch.term, target.host});
  SceneRecord now;
  std::string refusal;
  const bool moved = wait_until(kForAnswer, [&] {
    now = known_scene(directory, scene);
    refusal = known_host(directory, record.owner.name).wish_refusal;
    return now.owner == target.host || !refusal.empty();
  });
  if (now.owner == target.host)
    return who + " serves " + what + " now, in term " + std::to_string(now.version.epoch.term);
  throw std::runtime_error(what + " stays at host " + visible(now.owner.name) +
                           (moved ? ": " + visible(refusal) : "; see its log"));
}

}  // namespace feltwire
