#include "server/fleet/placement.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

constexpr double kPerCent = 0.01;
constexpr double kRounding = 1e-9;  // of sums of shares

/// A number below `count`, from 64 uniform bits; the bias is below count / 2^32.
std::size_t below(std::uint64_t bits, std::size_t count) {
  return static_cast<std::size_t>(((bits >> 32) * count) >> 32);
}

double load_with(const HostRoom& host, double further) {
  return load(host) + further / static_cast<double>(host.free_cores.size());
}

}  // namespace

HostRoom room_of(const HostRecord& record) {
  HostRoom room{record.host.number, {}, record.draining};
  room.free_cores.reserve(record.free_shares.size());
  for (const std::uint8_t share : record.free_shares)
    room.free_cores.push_back(std::min(1.0, kPerCent * share));
  return room;
}

double load(const HostRoom& host) {
  if (host.free_cores.empty()) return 1.0;
  const double free = std::accumulate(host.free_cores.begin(), host.free_cores.end(), 0.0);
  return 1.0 - free / static_cast<double>(host.free_cores.size());
}

std::optional<std::size_t> core_for(const HostRoom& host, const SceneCost& cost) {
  const double needed = cost.core_share + (1.0 - kFullestCore) - kRounding;
  std::optional<std::size_t> best;
  for (std::size_t core = 0; core < host.free_cores.size(); ++core) {
    const double free = host.free_cores[core];
    if (free >= needed && (!best || free < host.free_cores[*best])) best = core;
  }
  return best;
}

bool fits(const HostRoom& host, const SceneCost& cost) { return core_for(host, cost).has_value(); }

std::optional<std::size_t> place(std::span<const HostRoom> hosts, const SceneCost& cost,
                                 std::uint64_t random, std::span<const HostNumber> excluded) {
  std::vector<std::size_t> fitting;
  for (std::size_t host = 0; host < hosts.size(); ++host)
    if (!hosts[host].draining && fits(hosts[host], cost) &&
        std::ranges::find(excluded, hosts[host].number) == excluded.end())
      fitting.push_back(host);
  if (fitting.empty()) return std::nullopt;
  const std::size_t first = below(splitmix::draw(random, 0), fitting.size());
  if (fitting.size() == 1) return fitting[first];
  std::size_t second = below(splitmix::draw(random, 1), fitting.size() - 1);
  if (second >= first) ++second;
  const bool keep_first = load(hosts[fitting[first]]) <= load(hosts[fitting[second]]);
  return fitting[keep_first ? first : second];
}

bool overfull(const HostRoom& host, std::size_t core) {
  return host.free_cores[core] < 1.0 - kFullestCore - kRounding;
}

std::optional<Move> next_move(std::span<const HostRoom> hosts, std::size_t host,
                              std::span<const PlacedScene> scenes, std::uint64_t random) {
  const HostRoom& source = hosts[host];
  const HostNumber excluded[] = {source.number};
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    const SceneCost& cost = scenes[scene].cost;
    const bool must = source.draining || overfull(source, scenes[scene].core);
    const auto to = place(hosts, cost, splitmix::draw(random, scene), excluded);
    if (!to) continue;
    const double gain =
        load_with(source, -cost.core_share) - load_with(hosts[*to], cost.core_share);
    if (must || gain >= kMoveGain) return Move{scene, *to};
  }
  return std::nullopt;
}

}  // namespace feltwire
