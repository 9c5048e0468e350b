#include "client/c_api/caller_device.hpp"

#include "client/device/held_command.hpp"

namespace feltwire {

/// Returns the newer move with the mean force over both spans of time.
CallerDevice::Offer CallerDevice::joined(const Offer& older, const Offer& newer) noexcept {
  const double span = older.span + newer.span;
  if (!(span > 0.0)) return newer;
  const double share = older.span / span;
  return {newer.move, weighted(older.held, share, newer.held, 1.0 - share), span};
}

void CallerDevice::exchange(const Move& move, Nanoseconds now, const Command& applied) noexcept {
  const double span = exchanged_at_.count() > 0 ? seconds(now - exchanged_at_) : 0.0;
  waiting_ = joined(waiting_, {move, applied_, span});
  if (offers_.push(waiting_)) waiting_ = {};
  applied_ = applied;
  exchanged_at_ = now;
}

DeviceReading CallerDevice::read(Nanoseconds now) noexcept {
  DeviceReading reading;
  Offer all, offer;
  bool fresh = false;
  while (offers_.pop(offer)) {
    all = joined(all, offer);
    fresh = true;
  }
  if (fresh) {
    newest_ = all.move;
    reading.held = all.held;
    moved_ = true;
    moved_at_ = now;
  } else if (!moved_) {
    reading.withheld = Withheld::not_homed;
  } else if (now - moved_at_ > stale_after_) {
    reading.withheld = Withheld::not_moved;
  } else {
    reading.fresh = false;
  }
  reading.pose = newest_.pose;
  reading.buttons = newest_.buttons;
  reading.deadman = newest_.deadman;
  if (newest_.gripper >= 0.0) reading.gripper = newest_.gripper;
  return reading;
}

}  // namespace feltwire
