// Steps the moving objects of a scene with the forces of all hands, and finds who broke it.

#include <algorithm>

#include "server/scene/scene_sessions.hpp"

namespace feltwire {

void SceneSessions::tick(Nanoseconds now) noexcept {
  if (world_ == nullptr || slots_.empty()) return;
  const auto due = (now - last_tick_) / tick_;
  if (due == 0) return;
  log_.put({.kind = EventKind::tick, .time = now});
  counters_.world_late.record((now - last_tick_ - tick_).count());
  const auto late = due - most_ticks_;
  if (late > 0) [[unlikely]] {
    last_tick_ += late * tick_;
    counters_.ticks_dropped += static_cast<std::uint64_t>(late);
    world_->let_pass(static_cast<std::uint64_t>(late));
  }
  most_ticks_ = late > 0 ? std::max(1, most_ticks_ / 2) : std::min(kMostTicks, 2 * most_ticks_);
  while (now - last_tick_ >= tick_) {
    for (const auto& slot : slots_)
      if (!slot->disturbing) slot->session.push(seconds(last_tick_ - slot->last_heard));
    for (Seat& seat : seats_)
      if (seat.arm) seat.arm->drive(*world_, seat.link, last_tick_ + tick_);
    if (!world_->step()) blame(now);
    for (Seat& seat : seats_)
      if (seat.arm) seat.arm->sense(*world_);
    last_tick_ += tick_;
  }
}

std::optional<Nanoseconds> SceneSessions::next_tick() const {
  if (world_ == nullptr || slots_.empty()) return std::nullopt;
  return last_tick_ + tick_;
}

/// Finds the hands that broke the simulation: the hand that pushed the moving bodies hardest, and
/// each that pushed at least half as hard. A hand that only held something else, or lay on it
/// lightly, is not to blame.
void SceneSessions::blame(Nanoseconds now) noexcept {
  constexpr double kShare = 0.5;
  double hardest = 0.0;
  for (const auto& slot : slots_) hardest = std::max(hardest, slot->session.blame());
  if (!(hardest > 0.0)) return;  // it broke by itself
  for (const auto& slot : slots_)
    if (slot->session.blame() >= kShare * hardest)
      slot->disturbing = slot->disturbing || !slot->resets.take(now);
}

}  // namespace feltwire
