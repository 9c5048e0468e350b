#include "server/fleet_host/fleet_member.hpp"

#include <algorithm>
#include <utility>

#include "core/base/visible_text.hpp"
#include "protocol/net/ports.hpp"
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

}  // namespace

FleetMember::FleetMember(HostRecord about, const std::vector<LoadedFleetScene>& scenes,
                         const SigningKeys& keys)
    : about_(std::move(about)), keys_(keys), gate_(kTickets), hosts_(about_.host) {
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
      return Seat{*scene.ownership.serving, hosts_.others(record, join.ipv6)};
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
  const auto host = hosts_.address_of(record.owner, join.ipv6);
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
  if (found == scenes_.end() || found->second.ownership.serving || found->second.ownership.leaving)
    return std::nullopt;
  const HostName& owner = found->second.ownership.record.owner;
  if (owner.number == 0) return std::nullopt;
  const auto host = hosts_.address_of(owner, false);
  return owner.name + (host ? " at " + host_and_port(host->address, host->port) : std::string());
}

void FleetMember::see(Bucket bucket, const DirectoryEntry& entry, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  hosts_.begin(now);
  switch (bucket) {
    case Bucket::hosts:
      return see_host(entry, now);
    case Bucket::scenes:
      return see_scene(entry);
    case Bucket::wishes:
      return see_wish(entry, now);
    case Bucket::tokens:  // of FleetTokens
      return;
  }
}

void FleetMember::see_host(const DirectoryEntry& entry, Nanoseconds now) {
  const auto record = decode_host_record(entry.value);
  if (record && hosts_.see(entry.key, *record, now))
    ticket_keys_.set(entry.key, record->ticket_keys);
}

void FleetMember::see_scene(const DirectoryEntry& entry) {
  const auto record = decode_scene_record(entry.value);
  if (!record) return;
  KnownScene& scene = scenes_[entry.key];
  if (!see_record(scene.ownership, *record, entry.revision)) return;
  scene.move_to = {};
  scene.kept.clear();
  lost_.push_back(entry.key);
}

/// A wish is for one process, which carries it out once: a directory may deliver it again, after a
/// later one too.
void FleetMember::see_wish(const DirectoryEntry& entry, Nanoseconds now) {
  const auto wish = decode_wish(entry.value);
  if (!wish || wish->host != about_.host || wish->serial <= about_.wish) return;
  about_.wish = wish->serial;
  about_.wish_refusal = carry_out(*wish, now);
  news_ = true;
}

/// Returns why it cannot be done; empty: it will be done.
std::string FleetMember::carry_out(const Wish& wish, Nanoseconds now) {
  if (wish.kind == WishKind::undrain && ends_) return "the host is about to end";
  if (wish.kind != WishKind::move) {
    set_draining(wish.kind == WishKind::drain);
    return {};
  }
  const auto found = scenes_.find(wish.scene);
  if (found == scenes_.end() || !found->second.ownership.serving ||
      found->second.ownership.serving->term != wish.term)
    return "it does not serve scene " + visible(wish.scene) + " in term " +
           std::to_string(wish.term) + " any more";
  KnownScene& scene = found->second;
  if (auto unfit = hosts_.unfit(wish.target, scene_tag(wish.scene, *scene.loaded), now))
    return *std::move(unfit);
  scene.move_to = wish.target;
  scene.hand_over_from = now;
  return {};
}

void FleetMember::listed() {
  const std::lock_guard lock(mutex_);
  listed_ = true;
}

void FleetMember::heard(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  hosts_.heard(now);
}

HostRecord FleetMember::heartbeat(const Load& load) {
  const std::lock_guard lock(mutex_);
  ++about_.beat;
  about_.hands = load.hands;
  about_.free_shares = load.free_shares;
  about_.kept = kept();
  return about_;
}

/// Whether this host is the one to take the scene over if its owner is gone: it is the standby, or
/// there is none that lives.
bool FleetMember::may_take(const KnownScene& scene, Nanoseconds now) const {
  const SceneRecord& record = scene.ownership.record;
  const SceneOwnership& ownership = scene.ownership;
  if (!scene.loaded || ownership.serving || ownership.leaving || record.owner.number == 0)
    return false;
  if (record.standby.number == about_.host.number) return true;
  return record.standby.number == 0 || hosts_.silent(record.standby, now);
}

/// Names another standby if there is none that lives and takes scenes.
void FleetMember::name_standby(const std::string& name, KnownScene& scene, Nanoseconds now,
                               std::uint64_t random) {
  const HostName& standby = scene.ownership.record.standby;
  const std::uint64_t tag = scene_tag(name, *scene.loaded);
  const HostRecord* const known = hosts_.find(standby);
  const bool drains = known != nullptr && known->draining;
  if (standby.number != 0 && !drains && !hosts_.silent(standby, now)) return;
  const HostName chosen = hosts_.choose(tag, about_.rack, now, random);
  if (chosen.number != standby.number) reserve_standby(scene.ownership, chosen);
}

/// Whether nobody else is to have the scene that this host does not serve.
bool FleetMember::may_claim(const KnownScene& scene, Nanoseconds now) const {
  const SceneOwnership& ownership = scene.ownership;
  const SceneRecord& record = ownership.record;
  // The scene comes back if the other host has not taken it, even to a host that drains.
  if (ownership.leaving) return now >= scene.take_until || hosts_.gone(record.standby);
  // Without an answer to its claim, this host may have the record and not know that it serves.
  const bool free =
      record.owner.number == 0 || record.owner == about_.host || hosts_.gone(record.owner);
  if (!listed_ || !free || about_.draining) return false;
  // The standby comes first: it needs no write. If its heartbeats are missing, suspect() names it.
  return record.standby.number == 0 || record.standby == about_.host || hosts_.gone(record.standby);
}

std::vector<FleetMember::Write> FleetMember::writes(Nanoseconds now, std::uint64_t random) {
  const std::lock_guard lock(mutex_);
  std::vector<Write> result;
  for (auto& [name, scene] : scenes_) {
    SceneOwnership& ownership = scene.ownership;
    if (!scene.loaded) continue;
    // If it is the standby.
    if (hosts_.gone(ownership.record.owner)) take_over(ownership, about_.host);
    if (ownership.serving) name_standby(name, scene, now, random + result.size());
    if (!ownership.serving && may_claim(scene, now)) {
      if (ownership.leaving) take_back(scene, now);
      const SceneRecord claimed = claim(ownership, about_.host, *scene.loaded);
      result.push_back({name, claimed, ownership.revision, true});
    } else if (const auto record = record_to_write(ownership)) {
      result.push_back({name, *record, ownership.revision, false});
    }
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
    if (!(scene.wanted || hosts_.silent(record.owner, now)) || !may_take(scene, now)) continue;
    // The standby of an owner that is gone may serve already, while the directory does not know it.
    const HostName& host = hosts_.gone(record.owner) ? record.standby : record.owner;
    if (host.number == 0 || host == about_.host || hosts_.gone(host)) continue;
    const auto asked = asked_.find(host.number);
    if (asked != asked_.end() && now - asked->second < kProbeAgain) continue;
    scene.wanted = false;
    asked_[host.number] = now;
    const auto address = hosts_.address_of(host, false);
    if (address) return Suspect{host, address->address, address->port, address->fingerprint};
    // Nobody has heard of it while the directory was there: it has left no heartbeat.
    if (hosts_.silent(host, now)) return Suspect{host, {}, 0, {}};
  }
  return std::nullopt;
}

std::vector<std::string> FleetMember::probed(const HostName& host, bool answers) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken;
  if (answers) return taken;
  hosts_.lose(host);
  for (auto& [name, scene] : scenes_)
    if (scene.loaded && scene.ownership.record.owner == host && take_over(scene.ownership, self()))
      taken.push_back(name);
  return taken;
}

void FleetMember::drain(bool ends) {
  const std::lock_guard lock(mutex_);
  set_draining(true);
  ends_ = ends_ || ends;
  news_ = true;  // no host shall choose this one any more
}

/// Begins anew with all scenes: what kept one before need not do so now.
void FleetMember::set_draining(bool draining) {
  about_.draining = draining;
  for (auto& [name, scene] : scenes_) {
    scene.kept.clear();
    scene.hand_over_from = {};
  }
}

/// The scene has not been taken in time. It is this host's again once its claim is acknowledged.
void FleetMember::take_back(KnownScene& scene, Nanoseconds now) {
  const std::string& other = scene.ownership.record.standby.name;
  if (!other.empty()) scene.kept = "host " + visible(other) + " has not taken it";
  if (scene.move_to.number != 0) about_.wish_refusal = scene.kept;
  news_ = news_ || scene.move_to.number != 0;
  scene.move_to = {};
  scene.hand_over_from = now + kHandOverAgain;
}

/// The host that a scene is to go to; number 0: none, and `kept` says why.
HostName FleetMember::target_of(const std::string& name, KnownScene& scene, Nanoseconds now,
                                std::uint64_t random) const {
  if (scene.move_to.number != 0) return scene.move_to;
  const std::uint64_t tag = scene_tag(name, *scene.loaded);
  const HostName& standby = scene.ownership.record.standby;
  if (standby.number != 0 && !hosts_.unfit(standby, tag, now)) return standby;
  HostName chosen = hosts_.choose(tag, about_.rack, now, random);
  if (chosen.number == 0) scene.kept = "no other host that takes scenes has its files";
  return chosen;
}

std::vector<FleetMember::HandOver> FleetMember::hand_overs(Nanoseconds now, std::uint64_t random) {
  const std::lock_guard lock(mutex_);
  std::vector<HandOver> result;
  auto under_way = static_cast<std::size_t>(std::ranges::count_if(
      scenes_, [](const auto& entry) { return entry.second.ownership.leaving.has_value(); }));
  for (auto& [name, scene] : scenes_) {
    const bool asked = about_.draining || scene.move_to.number != 0;
    if (!asked || !scene.ownership.serving || now < scene.hand_over_from) continue;
    // The handover goes through the directory. While that is silent, the host keeps its scenes.
    if (!hosts_.directory_answers(now)) {
      scene.kept = "the directory does not answer";
      continue;
    }
    if (under_way >= kHandOversAtOnce) break;
    const HostName target = target_of(name, scene, now, random + result.size());
    const auto address = hosts_.address_of(target, false);
    if (!address) continue;
    ++under_way;
    result.push_back({name, {target, address->address, address->port, address->fingerprint}});
  }
  return result;
}

bool FleetMember::hand_over(const HandOver& asked, bool answers, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  KnownScene& scene = scenes_[asked.scene];
  if (!scene.ownership.serving) return false;
  if (!answers) {
    scene.kept = "host " + visible(asked.target.host.name) + " gives no answer";
    scene.hand_over_from = now + kHandOverAgain;
    if (std::exchange(scene.move_to, {}).number != 0) {
      about_.wish_refusal = scene.kept;
      news_ = true;
    }
    return false;
  }
  feltwire::hand_over(scene.ownership, asked.target.host);
  scene.take_until = now + kTakeTime;
  scene.kept.clear();
  return true;
}

std::vector<std::string> FleetMember::take_handed() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken;
  for (auto& [name, scene] : scenes_) {
    if (about_.draining || !is_handed_to(scene.ownership, about_.host)) continue;
    if (scene.loaded == scene.ownership.record.digest && take_over(scene.ownership, about_.host))
      taken.push_back(name);
  }
  return taken;
}

bool FleetMember::take_news() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, false);
}

bool FleetMember::drained() const {
  const std::lock_guard lock(mutex_);
  return std::ranges::none_of(scenes_, [](const auto& entry) {
    const KnownScene& scene = entry.second;
    return scene.ownership.leaving || (scene.ownership.serving && scene.kept.empty());
  });
}

/// The scenes that a host keeps although it drains, with the reasons, for people.
std::string FleetMember::kept() const {
  constexpr int kMost = 4;  // of many
  std::string text;
  int more = 0;
  if (!about_.draining) return text;
  for (const auto& [name, scene] : scenes_) {
    if (scene.kept.empty()) continue;
    if (text.empty())
      text = name + ": " + scene.kept;
    else if (more < kMost)
      text += "; " + name + ": " + scene.kept;
    ++more;
  }
  if (more > kMost + 1) text += "; and more";
  return text;
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
