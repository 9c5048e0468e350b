#include "server/fleet_host/known_hosts.hpp"

#include <algorithm>

#include "core/base/visible_text.hpp"
#include "server/fleet/placement.hpp"

namespace feltwire {
namespace {

bool is_ipv6(const std::string& address) { return address.find(':') != std::string::npos; }

}  // namespace

void KnownHosts::begin(Nanoseconds now) {
  if (began_ < Nanoseconds(0)) began_ = now;
}

void KnownHosts::heard(Nanoseconds now) {
  heard_ = now;
  begin(now);
}

bool KnownHosts::see(const std::string& key, const HostRecord& record, Nanoseconds now) {
  if (record.host.name != key || key == self_.name) return false;
  Known& known = hosts_[key];
  const HostName before = known.record.host;
  // A watch may deliver one heartbeat again and again: that is no sign of life.
  if (before == record.host && record.beat <= known.record.beat) return false;
  const auto ended = gone_.find(record.host.number);
  if (ended != gone_.end() && record.beat <= ended->second) return false;
  gone_.erase(record.host.number);
  if (before.number != 0 && before.number != record.host.number)
    gone_[before.number] = known.record.beat;
  known = {record, now};
  return true;
}

void KnownHosts::lose(const HostName& host) {
  const HostRecord* const known = find(host);
  gone_.emplace(host.number, known != nullptr ? known->beat : 0);
}

bool KnownHosts::directory_answers(Nanoseconds now) const {
  return heard_ >= Nanoseconds(0) && now - heard_ <= kSilent;
}

const HostRecord* KnownHosts::find(const HostName& host) const {
  const auto found = hosts_.find(host.name);
  return found != hosts_.end() && found->second.record.host == host ? &found->second.record
                                                                    : nullptr;
}

bool KnownHosts::gone(const HostName& host) const {
  if (host.name == self_.name) return host.number != self_.number;
  return gone_.contains(host.number);
}

bool KnownHosts::silent(const HostName& host, Nanoseconds now) const {
  if (gone(host)) return true;
  if (!directory_answers(now)) return false;
  const auto found = hosts_.find(host.name);
  const bool known = found != hosts_.end() && found->second.record.host == host;
  return now - (known ? found->second.heard : began_) > kSilent;
}

std::optional<std::string> KnownHosts::unfit(const HostName& host, std::uint64_t scene,
                                             Nanoseconds now) const {
  const HostRecord* const known = find(host);
  const std::string who = "host " + visible(host.name);
  if (known == nullptr || silent(host, now)) return who + " gives no sign of life";
  if (known->draining) return who + " drains";
  if (std::ranges::count(known->scenes, scene) == 0)
    return who + " has no scene of that name with the same files";
  return std::nullopt;
}

std::optional<control::FleetHost> KnownHosts::address_of(const HostName& host, bool ipv6) const {
  const HostRecord* const known = find(host);
  if (known == nullptr || known->addresses.empty()) return std::nullopt;
  const std::vector<std::string>& all = known->addresses;
  const auto same = std::ranges::find_if(
      all, [&](const std::string& address) { return is_ipv6(address) == ipv6; });
  return control::FleetHost{same != all.end() ? *same : all.front(), known->control_port,
                            known->fingerprint};
}

std::vector<control::FleetHost> KnownHosts::others(const SceneRecord& record, bool ipv6) const {
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

HostName KnownHosts::choose(std::uint64_t scene, std::string_view rack, Nanoseconds now,
                            std::uint64_t random) const {
  for (const bool other_rack : {true, false}) {
    std::vector<HostName> names;
    std::vector<HostRoom> rooms;
    for (const auto& [key, host] : hosts_) {
      const HostRecord& record = host.record;
      if (unfit(record.host, scene, now)) continue;
      if (other_rack && !rack.empty() && record.rack == rack) continue;
      names.push_back(record.host);
      rooms.push_back(room_of(record));
    }
    if (names.empty()) continue;
    const auto chosen = place(rooms, SceneCost{}, random);
    return names[chosen.value_or(random % names.size())];
  }
  return {};
}

}  // namespace feltwire
