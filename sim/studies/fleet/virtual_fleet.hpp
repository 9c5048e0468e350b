#pragma once
// A fleet in virtual time: hosts, scenes, hands and a directory with its delays. Who serves a scene
// is decided by server/fleet/ownership, where it goes by server/fleet/placement, and what a hand
// accepts by protocol/fleet: the functions of the product.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "core/base/histogram.hpp"
#include "protocol/fleet/session_epoch.hpp"
#include "server/fleet/ownership.hpp"
#include "server/fleet/placement.hpp"
#include "sim/studies/fleet/fleet_inputs.hpp"

namespace feltwire::fleet {

inline constexpr std::uint32_t kNobody = ~std::uint32_t{0};

/// Amounts by second.
class PerSecond {
 public:
  void add(double time, double amount) {
    const auto second = static_cast<std::size_t>(std::max(0.0, time));
    if (second >= seconds_.size()) seconds_.resize(second + 1);
    peak_ = std::max(peak_, seconds_[second] += amount);
  }
  double peak() const { return peak_; }  // of the busiest second

 private:
  std::vector<double> seconds_;
  double peak_ = 0.0;
};

/// Counts since the last reset.
struct FleetCounts {
  std::uint64_t joins = 0, attempts = 0, crowded_out = 0, takeovers = 0, moves = 0;
  std::uint64_t lower_epochs = 0;  // sessions that a hand refused, since it has seen a later owner
  std::uint64_t writes = 0;
  double bytes = 0.0;  // to the directory, and from it to all hosts
  PerSecond joins_by_second, bytes_by_second;
  double last_join = 0.0;      // [s] when the last hand that had lost its session was back
  double last_standby = 0.0;   // [s] when the last scene without a live standby got one
  double last_overfull = 0.0;  // [s] when the last overfull core was relieved
  Histogram without_session;   // [us] of each hand that lost one
};

class VirtualFleet {
 public:
  VirtualFleet(const FleetInputs& inputs, std::uint32_t hosts);
  VirtualFleet(const VirtualFleet&) = delete;  // its events refer to it
  VirtualFleet& operator=(const VirtualFleet&) = delete;

  /// Places all scenes and their standbys, without time. Returns whether all found a place.
  bool place_all();
  /// All hands have a session. Call it after place_all(), when the fleet stays where it is.
  void seat_all();

  double now() const { return now_; }
  void at(double time, std::function<void()> action);
  /// Does all that is due before `end`; false if nothing is left to do.
  void run(double end);

  // Faults and works; each begins now.
  void kill_hosts(std::uint32_t first, std::uint32_t count);
  void stall_directory(double until) { directory_free_ = std::max(directory_free_, until); }
  /// Hosts [first, first + count) lose the directory and the other hosts, and half of their hands
  /// lose them.
  void cut_off(std::uint32_t first, std::uint32_t count);
  void heal();
  /// Moves all scenes away, then starts the host again. Calls `done` when it is back.
  void drain(std::uint32_t host, std::function<void()> done);
  /// The hand has no session from now on, and tries to join as soon as it notices.
  void lose(std::uint32_t hand, double until_noticed);
  /// A host writes to the directory; calls `done` when that is acknowledged. Nothing happens while
  /// the host is cut off from it.
  void write(std::uint32_t host, std::size_t bytes, std::function<void()> done);

  const FleetCounts& counts() const { return counts_; }
  /// Begins to count anew, now.
  void reset_counts() {
    counts_ = {};
    counted_from_ = now_;
  }
  std::uint32_t hands_without_session() const { return outside_; }
  std::uint32_t scenes_without_standby() const {
    return count(scenes_, [&](const Scene& scene) {
      return scene.standby == kNobody || !hosts_[scene.standby].alive;
    });
  }
  std::uint32_t scenes_in_two_rooms() const {
    return count(scenes_, [](const Scene& scene) { return scene.former != kNobody; });
  }
  std::uint32_t overfull_cores() const;
  std::uint32_t draining_hosts() const {
    return count(hosts_, [](const Host& host) { return static_cast<bool>(host.drained); });
  }
  std::uint32_t hosts() const { return static_cast<std::uint32_t>(hosts_.size()); }
  std::uint32_t hands() const { return static_cast<std::uint32_t>(hands_.size()); }
  double highest_load() const;
  Draws& draws() { return draws_; }

 private:
  struct Host {
    HostName self;
    std::string rack;
    bool alive = true, cut = false;
    double joins_free = 0.0;              // [s] when its control thread has nothing left to do
    std::vector<std::uint32_t> scenes{};  // that it serves
    std::uint32_t moving = 0;             // of them, on their way to another host
    std::function<void()> drained{};      // while it drains
  };
  struct Scene {
    SceneCost cost;
    std::uint32_t first_hand = 0, hands = 0;
    std::uint32_t owner = kNobody, standby = kNobody, former = kNobody;  // hosts
    std::size_t core = 0, former_core = 0;
    SceneOwnership at_owner, at_standby, at_former;
    double ready = 0.0;  // [s] when it is loaded at the owner
    bool moving = false;
  };
  struct Hand {
    SessionEpoch known;
    std::uint32_t scene = 0, attempts = 0;
    double lost = 0.0;     // [s]
    bool cut = false;      // from the hosts that are cut off
    bool waiting = false;  // it has no session and wants one
  };
  struct Event {
    double time = 0.0;
    std::uint64_t order = 0;
    std::function<void()> action;
    bool operator>(const Event& other) const {
      return time != other.time ? time > other.time : order > other.order;
    }
  };

  static std::uint32_t count(const auto& all, const auto& which) {
    return static_cast<std::uint32_t>(std::ranges::count_if(all, which));
  }
  std::size_t take_core(std::uint32_t scene, std::uint32_t host);
  void occupy(std::uint32_t scene, std::uint32_t host, std::size_t core);
  void vacate(std::uint32_t scene, std::uint32_t host, std::size_t core);
  std::vector<HostNumber> rack_of(std::uint32_t host) const;
  void write_record(std::uint32_t scene);
  void release_former(std::uint32_t scene, const SceneRecord& record, std::uint64_t revision);
  void name_standby(std::uint32_t scene);
  void name_missing_standbys();
  bool reaches(const Hand& hand, std::uint32_t host) const {
    return host != kNobody && hosts_[host].alive && !(hand.cut && hosts_[host].cut);
  }
  void attempt(std::uint32_t hand);
  void retry(std::uint32_t hand, double after);
  void join(std::uint32_t hand, std::uint32_t host);
  void take_over_scene(std::uint32_t scene);
  void move(std::uint32_t scene, std::uint32_t to);
  void finish_move(std::uint32_t scene, std::uint32_t source, std::uint32_t to, std::size_t core,
                   const std::optional<SceneOwnership>& target);
  std::optional<Move> next_move_of(std::uint32_t host, bool overfull_only);
  void drain_further(std::uint32_t host);
  void rebalance();

  FleetInputs inputs_;
  Draws draws_;
  double now_ = 0.0;
  std::uint64_t ordered_ = 0;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::vector<Host> hosts_;
  std::vector<HostRoom> rooms_;  // as heartbeats tell them: a dead host drains once it has aged
  std::vector<Scene> scenes_;
  std::vector<Hand> hands_;
  double directory_free_ = 0.0;
  std::uint64_t revision_ = 0;
  HostNumber started_ = 0;
  std::uint32_t outside_ = 0;
  FleetCounts counts_;
  double counted_from_ = 0.0;
};

}  // namespace feltwire::fleet
