#pragma once
// The choice of a host for each scene: functions of numbers that hosts announce, without a clock
// and without a random generator of their own.
//
// The place is the better of two hosts that are drawn at random. That spreads the load nearly as
// well as a look at all hosts would, and two hosts that place at the same time do not both choose
// the one that is emptiest (M. Mitzenmacher: The power of two choices in randomized load balancing,
// IEEE TPDS 12(10), 2001).

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/fleet/epoch.hpp"
#include "server/fleet/scene_record.hpp"

namespace feltwire {

/// The room of a host. Shares are of one pinned core.
struct HostRoom {
  HostNumber number = 0;
  std::vector<double> free_cores;  // of each pinned core, the free share: 0 to 1
  bool draining = false;
};
HostRoom room_of(const HostRecord& record);

/// The cost of a scene: a share of one core, since a scene has one thread.
struct SceneCost {
  double core_share = 0.0;
};
/// From the number of hands, each of which costs its share at the rate of its samples, and the
/// share that the scene needs with no hand (moving bodies).
constexpr SceneCost scene_cost(std::uint32_t hands, double share_of_a_hand, double share_at_rest) {
  return {share_at_rest + hands * share_of_a_hand};
}

/// The share of all cores that is in use; 1: the host has no core.
double load(const HostRoom& host);
/// Whether one core has room for the scene. A core is filled to kFullestCore at most.
bool fits(const HostRoom& host, const SceneCost& cost);
inline constexpr double kFullestCore = 0.9;  // the rest is for the worst second of a scene

/// The core that the scene goes to: the fullest one that has room, so that whole cores stay free
/// for large scenes. Empty: none has room.
std::optional<std::size_t> core_for(const HostRoom& host, const SceneCost& cost);

/// Returns the index of the host for a scene: of two different hosts that fit, drawn by `random`
/// (64 uniform bits), the one with the lower load. Never one of `excluded`, never one that drains.
/// Empty: no host fits.
std::optional<std::size_t> place(std::span<const HostRoom> hosts, const SceneCost& cost,
                                 std::uint64_t random, std::span<const HostNumber> excluded = {});

/// A scene of a host, for next_move().
struct PlacedScene {
  SceneCost cost;
  std::size_t core = 0;  // of the host
};
struct Move {
  std::size_t scene = 0, to = 0;  // indices
};
/// A move is worth its trouble only beyond this difference of load, so that no scene moves back.
inline constexpr double kMoveGain = 0.1;

/// Whether the core uses more than kFullestCore.
bool overfull(const HostRoom& host, std::size_t core);

/// The next of its `scenes` to move away from hosts[host], or none: of a host that drains any, of
/// an overfull core any, else one whose move leaves the target's load below the host's by
/// kMoveGain. `random` as for place().
std::optional<Move> next_move(std::span<const HostRoom> hosts, std::size_t host,
                              std::span<const PlacedScene> scenes, std::uint64_t random);

}  // namespace feltwire
