#include "server/scene/pace.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/written_number.hpp"
#include "protocol/session/slowest_pace.hpp"

namespace feltwire {
namespace {

/// A session is as busy as its share allows from this part of the share on.
constexpr double kBusy = 0.8;
/// The thread is still short of time while it has so much load, for so long after the last limit.
constexpr double kFull = 0.95 * FairShare::kMost;
constexpr Nanoseconds kFades{200'000'000};

Slowed kind_of(const SessionSlot& slot) noexcept {
  return slot.session.observes() ? Slowed::observers : Slowed::hands;
}

/// The time [s] between two datagrams, as granted.
double interval_of(const SessionParameters& parameters) noexcept {
  return parameters.packet_interval * parameters.servo_period;
}

/// The last step: the slowest pace that is a power of two.
std::uint8_t last_step(const SessionParameters& parameters) noexcept {
  const int most = slowest_pace(parameters);
  std::uint8_t pace = 1;
  while (pace < Pace::kMost && 2 * pace <= most) pace = static_cast<std::uint8_t>(2 * pace);
  return pace;
}

}  // namespace

void Pace::set(SessionSlot& slot, std::uint8_t intervals, Nanoseconds now) noexcept {
  if (intervals > slot.pace.intervals) ++counters_.slowed;
  slot.pace = {.intervals = intervals, .since = now};
  changed_ = true;
  log_.put({.kind = EventKind::pace,
            .hand = slot.number,
            .time = now,
            .payload = {&slot.pace.intervals, 1}});
}

void Pace::look(const SessionSlots& slots, const FairShare& share, Nanoseconds now) noexcept {
  looked_ = now;
  // Datagrams that are dropped give the thread some time, so that the level is finite now and then.
  if (std::isfinite(share.level())) {
    level_ = share.level();
    limited_ = now;
  }
  if (limited_ && now - *limited_ < kFades && share.load() >= kFull) {
    calm_since_.reset();
    if (!short_since_) {
      short_since_ = now;
      // The thread is short soon after a step back: that was too early.
      if (sped_up_ && now - *sped_up_ < calm_) calm_ = std::min(2 * calm_, kLongestCalm);
    }
    if (now - *short_since_ < kShort) return;
    for (const Slowed kind : order_)
      if (slow_down(slots, share, kind, now)) return;
    return;
  }
  short_since_.reset();
  if (share.load() > kCalmLoad) {
    calm_since_.reset();
    return;
  }
  if (!calm_since_) calm_since_ = now;
  if (now - *calm_since_ < calm_) return;
  speed_up(slots, now);
  calm_since_ = now;
}

/// Returns whether there is a session of this kind that sends less from now on, or was asked to
/// just now.
bool Pace::slow_down(const SessionSlots& slots, const FairShare& share, Slowed kind,
                     Nanoseconds now) noexcept {
  bool any = false;
  for (const auto& slot : slots) {
    if (kind_of(*slot) != kind || slot->role == Role::follower) continue;
    const bool busy = kind == Slowed::observers || share.used(slot->share) >= kBusy * level_;
    if (!busy || slot->pace.intervals >= last_step(slot->session.parameters())) continue;
    any = true;
    if (now - slot->pace.since >= kSettle)
      set(*slot, static_cast<std::uint8_t>(2 * slot->pace.intervals), now);
  }
  return any;
}

void Pace::speed_up(const SessionSlots& slots, Nanoseconds now) noexcept {
  bool any = false;
  for (const auto& slot : slots) {
    if (slot->pace.intervals <= 1) continue;
    any = true;
    set(*slot, static_cast<std::uint8_t>(slot->pace.intervals / 2), now);
  }
  if (any)
    sped_up_ = now;
  else
    calm_ = kCalm;
}

std::string Pace::line(const SessionSlots& slots, Nanoseconds now) {
  changed_ = false;
  told_ = now;
  std::size_t slowed = 0;
  double longest = 0.0;
  for (const auto& slot : slots) {
    if (slot->pace.intervals <= 1) continue;
    ++slowed;
    const SessionParameters& parameters = slot->session.parameters();
    longest = std::max(longest, slot->pace.intervals * interval_of(parameters));
  }
  if (slowed == 0) return "all clients send as many datagrams as at their start again";
  return "the clients of " + std::to_string(slowed) + " of " + std::to_string(slots.size()) +
         " sessions are asked for fewer datagrams, because the scene's thread is short of time: "
         "they send one every " +
         printed("%.3g ms", 1e3 * longest) + " or sooner (--slow-down)";
}

}  // namespace feltwire
