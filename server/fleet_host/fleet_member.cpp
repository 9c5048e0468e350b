#include "server/fleet_host/fleet_member.hpp"

#include <algorithm>
#include <utility>

#include "protocol/net/ports.hpp"
#include "server/fleet/placement.hpp"
#include "server/fleet/record_codec.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

constexpr std::size_t kTickets = 100'000;  // in a minute or so; ReplayCache has the memory of each

Refused nobody(std::string_view scene) {
  return {RefusalCode::failed, "no host of the fleet serves scene '" + std::string(scene) +
                                   "' at present, as far as this one knows; try again"};
}

bool is_ipv6(const std::string& address) { return address.find(':') != std::string::npos; }

}  // namespace

FleetMember::FleetMember(HostRecord about, const std::vector<LoadedFleetScene>& scenes,
                         const SigningKeys& keys)
    : about_(std::move(about)), keys_(keys), gate_(kTickets) {
  about_.ticket_keys = keys_.valid();
  ticket_keys_.set(about_.host.name, about_.ticket_keys);
  for (const LoadedFleetScene& scene : scenes) {
    scenes_[scene.name].loaded = scene.digest;
    about_.scenes.push_back(scene_tag(scene.name, scene.digest));
  }
}

std::optional<FleetMember::Answer> FleetMember::answer(const Join& join, Nanoseconds now,
                                                       std::chrono::sys_seconds date) {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(join.scene);
  if (found == scenes_.end()) return std::nullopt;
  KnownScene& scene = found->second;
  if (!join.ticket.empty())
    if (auto refused = check_ticket(scene, join, date)) return *std::move(refused);
  const SceneRecord& record = scene.ownership.record;
  switch (answer_join(scene.ownership, join.seen)) {
    case JoinAnswer::accepted:
      return Seat{*scene.ownership.serving, others(record, join.ipv6)};
    case JoinAnswer::redirected:
      // The client may come because the owner is silent: see whether it is.
      scene.wanted = scene.wanted || may_take(scene, now);
      return redirect(scene, join, date);
    case JoinAnswer::unknown:
      break;
  }
  return nobody(join.scene);
}

/// Refuses a ticket that does not open this scene for this client here. A good one uses up.
std::optional<Refused> FleetMember::check_ticket(KnownScene& scene, const Join& join,
                                                 std::chrono::sys_seconds date) {
  const SceneOwnership& ownership = scene.ownership;
  const Epoch epoch = ownership.serving ? *ownership.serving : Epoch{};
  const TicketGate::Checked checked =
      gate_.check(join.ticket, {join.scene, about_.host.name, epoch}, ticket_keys_, date);
  const auto refuse = [](std::string_view why) {
    return Refused{RefusalCode::bad_ticket,
                   "the ticket of the redirect is not good: " + std::string(why) + "; join anew"};
  };
  if (checked.refusal) return refuse(name(*checked.refusal));
  if (checked.ticket.client != join.client) return refuse("wrong client");
  if (checked.ticket.role != join.role) return refuse("wrong role");
  return std::nullopt;
}

FleetMember::Answer FleetMember::redirect(const KnownScene& scene, const Join& join,
                                          std::chrono::sys_seconds date) const {
  const SceneRecord& record = scene.ownership.record;
  if (record.owner == about_.host) return nobody(join.scene);
  const auto host = address_of(record.owner, join.ipv6);
  const std::string text = "scene '" + std::string(join.scene) + "' is served by host " +
                           record.owner.name + " of the fleet";
  if (!host)
    return Refused{RefusalCode::failed, text + ", which has not told its address yet; try again"};
  if (!join.follows_redirects)
    return Refused{RefusalCode::not_supported,
                   text + "; join at " + host_and_port(host->address, host->port)};
  const Ticket ticket{std::string(join.scene), join.client, join.role, record.owner.name,
                      record.version.epoch,    date,        {}};
  return control::Redirected{*host, issue_ticket(ticket, keys_.signing()), record.version.epoch};
}

std::optional<std::string> FleetMember::elsewhere(std::string_view scene) const {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(scene);
  if (found == scenes_.end() || found->second.ownership.serving) return std::nullopt;
  const HostName& owner = found->second.ownership.record.owner;
  if (owner.number == 0) return std::nullopt;
  const auto host = address_of(owner, false);
  return owner.name + (host ? " at " + host_and_port(host->address, host->port) : std::string());
}

void FleetMember::see(Bucket bucket, const DirectoryEntry& entry, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (began_ < Nanoseconds(0)) began_ = now;
  if (bucket == Bucket::hosts) return see_host(entry, now);
  see_scene(entry);
}

void FleetMember::see_host(const DirectoryEntry& entry, Nanoseconds now) {
  auto record = decode_host_record(entry.value);
  if (!record || record->host.name != entry.key || record->host.name == about_.host.name) return;
  KnownHost& known = hosts_[entry.key];
  const HostName& before = known.record.host;
  // A watch may deliver one heartbeat again and again: that is no sign of life.
  if (before == record->host && record->beat <= known.record.beat) return;
  const auto ended = gone_.find(record->host.number);
  if (ended != gone_.end() && record->beat <= ended->second) return;
  gone_.erase(record->host.number);
  if (before.number != 0 && before.number != record->host.number)
    gone_[before.number] = known.record.beat;
  ticket_keys_.set(entry.key, record->ticket_keys);
  known = {*std::move(record), now};
}

void FleetMember::see_scene(const DirectoryEntry& entry) {
  const auto record = decode_scene_record(entry.value);
  if (!record) return;
  if (see_record(scenes_[entry.key].ownership, *record, entry.revision)) lost_.push_back(entry.key);
}

void FleetMember::listed() {
  const std::lock_guard lock(mutex_);
  listed_ = true;
}

void FleetMember::heard(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  heard_ = now;
  if (began_ < Nanoseconds(0)) began_ = now;
}

HostRecord FleetMember::heartbeat(const Load& load) {
  const std::lock_guard lock(mutex_);
  ++about_.beat;
  about_.hands = load.hands;
  about_.free_shares = load.free_shares;
  return about_;
}

const FleetMember::KnownHost* FleetMember::find(const HostName& host) const {
  const auto found = hosts_.find(host.name);
  return found != hosts_.end() && found->second.record.host == host ? &found->second : nullptr;
}

/// Whether the process has ended for certain.
bool FleetMember::gone(const HostName& host) const {
  if (host.name == about_.host.name) return host.number != about_.host.number;
  return gone_.contains(host.number);
}

/// Whether no heartbeat of it has come for some time. Nothing is known about it while the directory
/// itself is silent.
bool FleetMember::silent(const HostName& host, Nanoseconds now) const {
  if (gone(host)) return true;
  if (heard_ < Nanoseconds(0) || now - heard_ > kSilent) return false;
  const KnownHost* const known = find(host);
  return now - (known != nullptr ? known->heard : began_) > kSilent;
}

/// Whether this host is the one to take the scene over if its owner is gone: it is the standby, or
/// there is none that lives.
bool FleetMember::may_take(const KnownScene& scene, Nanoseconds now) const {
  const SceneRecord& record = scene.ownership.record;
  if (!scene.loaded || scene.ownership.serving || record.owner.number == 0) return false;
  if (record.standby.number == about_.host.number) return true;
  return record.standby.number == 0 || silent(record.standby, now);
}

std::optional<control::FleetHost> FleetMember::address_of(const HostName& host, bool ipv6) const {
  const KnownHost* const known = find(host);
  if (known == nullptr || known->record.addresses.empty()) return std::nullopt;
  const std::vector<std::string>& all = known->record.addresses;
  const auto same = std::ranges::find_if(
      all, [&](const std::string& address) { return is_ipv6(address) == ipv6; });
  return control::FleetHost{same != all.end() ? *same : all.front(), known->record.control_port,
                            known->record.fingerprint};
}

/// The hosts to ask if this one is silent: the standby, then any others.
std::vector<control::FleetHost> FleetMember::others(const SceneRecord& record, bool ipv6) const {
  std::vector<control::FleetHost> result;
  const auto add = [&](const HostName& host) {
    const auto address = address_of(host, ipv6);
    if (address && result.size() < control::kMaxFleetHosts &&
        std::ranges::count(result, *address) == 0)
      result.push_back(*address);
  };
  add(record.standby);
  for (const auto& [name, host] : hosts_) add(host.record.host);
  return result;
}

/// Returns a host with the scene's files: of two that are drawn at random, the one with more room,
/// in another rack if there is one. Number 0: there is none.
HostName FleetMember::choose_standby(const std::string& name, const KnownScene& scene,
                                     Nanoseconds now, std::uint64_t random) const {
  const std::uint64_t tag = scene_tag(name, *scene.loaded);
  for (const bool other_rack : {true, false}) {
    std::vector<HostName> names;
    std::vector<HostRoom> rooms;
    for (const auto& [key, host] : hosts_) {
      const HostRecord& record = host.record;
      if (silent(record.host, now) || record.draining ||
          std::ranges::count(record.scenes, tag) == 0)
        continue;
      if (other_rack && !about_.rack.empty() && record.rack == about_.rack) continue;
      names.push_back(record.host);
      rooms.push_back(room_of(record));
    }
    if (names.empty()) continue;
    const auto chosen = place(rooms, SceneCost{}, random);
    return names[chosen.value_or(random % names.size())];
  }
  return {};
}

std::vector<FleetMember::Write> FleetMember::writes(Nanoseconds now, std::uint64_t random) {
  const std::lock_guard lock(mutex_);
  std::vector<Write> result;
  for (auto& [name, scene] : scenes_) {
    SceneOwnership& ownership = scene.ownership;
    if (!scene.loaded) continue;
    if (gone(ownership.record.owner)) take_over(ownership, about_.host);  // if it is the standby
    if (ownership.serving) {
      const HostName& standby = ownership.record.standby;
      if (standby.number == 0 || silent(standby, now)) {
        const HostName chosen = choose_standby(name, scene, now, random + result.size());
        if (chosen.number != standby.number) reserve_standby(ownership, chosen);
      }
      if (const auto record = record_to_write(ownership))
        result.push_back({name, *record, ownership.revision, false});
      continue;
    }
    const SceneRecord& record = ownership.record;
    // Without an answer to its claim, this host may have the record and not know that it serves.
    const bool free = record.owner.number == 0 || record.owner == about_.host || gone(record.owner);
    if (!listed_ || !free || about_.draining) continue;
    // The standby comes first: it needs no write. If its heartbeats are missing, suspect() names
    // it.
    if (record.standby.number != 0 && record.standby != about_.host && !gone(record.standby))
      continue;
    const SceneRecord claimed = claim(ownership, about_.host, *scene.loaded);
    result.push_back({name, claimed, ownership.revision, true});
  }
  return result;
}

void FleetMember::finish(const Write& write, const WriteAnswer& answer) {
  if (answer.result != WriteResult::written) return;  // the watch tells what the directory has
  const std::lock_guard lock(mutex_);
  SceneOwnership& ownership = scenes_[write.scene].ownership;
  if (write.claims) {
    finish_claim(ownership, write.record, answer.revision);
  } else {
    finish_write(ownership, write.record, answer.revision);
  }
}

std::optional<FleetMember::Suspect> FleetMember::suspect(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  for (auto& [name, scene] : scenes_) {
    const SceneRecord& record = scene.ownership.record;
    if (!(scene.wanted || silent(record.owner, now)) || !may_take(scene, now)) continue;
    // The standby of an owner that is gone may serve already, while the directory does not know it.
    const HostName& host = gone(record.owner) ? record.standby : record.owner;
    if (host.number == 0 || host == about_.host || gone(host)) continue;
    const auto asked = asked_.find(host.number);
    if (asked != asked_.end() && now - asked->second < kProbeAgain) continue;
    scene.wanted = false;
    asked_[host.number] = now;
    const auto address = address_of(host, false);
    if (address) return Suspect{host, address->address, address->port, address->fingerprint};
    // Nobody has heard of it while the directory was there: it has left no heartbeat.
    if (silent(host, now)) return Suspect{host, {}, 0, {}};
  }
  return std::nullopt;
}

std::vector<std::string> FleetMember::probed(const HostName& host, bool answers) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken;
  if (answers) return taken;
  const KnownHost* const known = find(host);
  gone_.emplace(host.number, known != nullptr ? known->record.beat : 0);
  for (auto& [name, scene] : scenes_)
    if (scene.loaded && scene.ownership.record.owner == host && take_over(scene.ownership, self()))
      taken.push_back(name);
  return taken;
}

void FleetMember::announce(const paseto::SigningKey& next) {
  const std::lock_guard lock(mutex_);
  keys_.announce(next);
  about_.ticket_keys = keys_.valid();
}

void FleetMember::change_key() {
  const std::lock_guard lock(mutex_);
  keys_.change();
}

std::vector<std::string> FleetMember::take_lost() {
  const std::lock_guard lock(mutex_);
  return std::exchange(lost_, {});
}

std::vector<std::string> FleetMember::served() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, scene] : scenes_)
    if (scene.ownership.serving) names.push_back(name);
  return names;
}

}  // namespace feltwire
