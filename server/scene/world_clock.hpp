#pragma once
// The time of a scene's moving objects: when they step, and which hand broke a step.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/base/time_counts.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"
#include "server/scene/robot_seat.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

struct WorldClockCounters {
  WorldCounters world;              // of all worlds so far; zero if nothing moves
  std::uint64_t ticks_dropped = 0;  // of the world, when the thread could not keep up
  TimeCounts world_late;            // delay of each waking for the world after its time
};

/// Owns the world of the moving objects, and steps it by the scene's clock, which is an argument.
class WorldClock {
 public:
  /// A call makes up for at most so many ticks.
  static constexpr int kMostTicks = 20;

  /// The world of a scene, which must outlive it; null: nothing moves there. Allocates.
  static std::unique_ptr<World> world_of(const Scene& scene);

  /// Steps this world from now on; null: nothing moves. Returns the world before it.
  std::unique_ptr<World> run(std::unique_ptr<World> world, Nanoseconds now) noexcept;
  /// The time begins, because the first session joins.
  void begin(Nanoseconds now) noexcept { last_tick_ = now; }

  /// Whether a tick is due.
  bool is_due(Nanoseconds now) const noexcept {
    return world_ != nullptr && (now - last_tick_) / tick_ != 0;
  }
  /// Makes all ticks that are due, with the push of each hand and the motors of each arm. If there
  /// are more than the limit, it drops the rest of the time and halves the limit; otherwise the
  /// limit doubles, up to kMostTicks. A hand that broke the simulation again and again is
  /// `disturbing` from then on. It allocates only if the contacts need more room than ever before
  /// (docs/moving.md).
  void tick(Nanoseconds now, const SessionSlots& hands, std::span<RobotSeat> seats) noexcept;
  /// The time of the next tick; empty: nothing moves.
  std::optional<Nanoseconds> next_tick() const noexcept;

  /// Null: nothing moves.
  World* world() noexcept { return world_.get(); }
  const World* world() const noexcept { return world_.get(); }
  /// Whether moving objects were put back a short time ago (World::recovering).
  bool is_recovering() const noexcept { return world_ != nullptr && world_->recovering(); }

  std::uint64_t ticks_dropped() const noexcept { return counters_.ticks_dropped; }
  const TimeCounts& world_late() const noexcept { return counters_.world_late; }
  /// The running world included.
  WorldClockCounters counters() const;

 private:
  void drop_late_ticks(Nanoseconds now) noexcept;

  std::unique_ptr<World> world_;
  Nanoseconds tick_{0}, last_tick_{0};  // of the world: length, time
  int most_ticks_ = kMostTicks;  // largest number of ticks that one call makes up for at present
  WorldClockCounters counters_;
};

}  // namespace feltwire
