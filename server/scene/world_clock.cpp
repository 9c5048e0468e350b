#include "server/scene/world_clock.hpp"

#include <algorithm>
#include <utility>

namespace feltwire {
namespace {

void add(WorldCounters& sum, const WorldCounters& more) {
  sum.steps += more.steps;
  sum.resets += more.resets;
  sum.returned += more.returned;
  sum.warnings += more.warnings;
}

/// Blames hands for a bad step of the simulation: the hand that pushed the failed bodies hardest,
/// and each hand that pushed them at least half as hard. A hand that is blamed too often becomes
/// `disturbing`.
void blame(const SessionSlots& hands, Nanoseconds now) noexcept {
  constexpr double kShare = 0.5;
  double hardest = 0.0;
  for (const auto& hand : hands) hardest = std::max(hardest, hand->session.blame());
  if (!(hardest > 0.0)) return;  // no hand pushed the bodies that failed
  for (const auto& hand : hands)
    if (hand->session.blame() >= kShare * hardest)
      hand->blame.disturbing = hand->blame.disturbing || !hand->blame.resets.take(now);
}

}  // namespace

std::unique_ptr<World> WorldClock::world_of(const Scene& scene) {
  return scene.mechanism() == nullptr ? nullptr : std::make_unique<World>(scene);
}

std::unique_ptr<World> WorldClock::run(std::unique_ptr<World> world, Nanoseconds now) noexcept {
  if (world_ != nullptr) add(counters_.world, world_->counters());
  world_.swap(world);
  if (world_ != nullptr) tick_ = from_seconds(world_->tick());
  last_tick_ = now;
  return world;
}

void WorldClock::tick(Nanoseconds now, const SessionSlots& hands,
                      std::span<RobotSeat> seats) noexcept {
  if (!is_due(now)) return;
  counters_.world_late.record((now - last_tick_ - tick_).count());
  drop_late_ticks(now);
  while (now - last_tick_ >= tick_) {
    for (const auto& hand : hands)
      if (!hand->blame.disturbing) hand->session.push(seconds(last_tick_ - hand->last_heard));
    for (RobotSeat& seat : seats)
      if (seat.arm) seat.arm->drive(*world_, seat.link, last_tick_ + tick_);
    if (!world_->step()) blame(hands, now);
    for (RobotSeat& seat : seats)
      if (seat.arm) seat.arm->sense(*world_);
    last_tick_ += tick_;
  }
}

void WorldClock::drop_late_ticks(Nanoseconds now) noexcept {
  const auto late = (now - last_tick_) / tick_ - most_ticks_;
  if (late > 0) [[unlikely]] {
    last_tick_ += late * tick_;
    counters_.ticks_dropped += static_cast<std::uint64_t>(late);
    world_->let_pass(static_cast<std::uint64_t>(late));
  }
  most_ticks_ = late > 0 ? std::max(1, most_ticks_ / 2) : std::min(kMostTicks, 2 * most_ticks_);
}

std::optional<Nanoseconds> WorldClock::next_tick() const noexcept {
  if (world_ == nullptr) return std::nullopt;
  return last_tick_ + tick_;
}

WorldClockCounters WorldClock::counters() const {
  WorldClockCounters sum = counters_;
  if (world_ != nullptr) add(sum.world, world_->counters());
  return sum;
}

}  // namespace feltwire
