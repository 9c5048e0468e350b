#include "client/c_api/caller_device.hpp"

#include <poll.h>

#include <algorithm>
#include <ctime>

#include "client/device/held_command.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

/// Waits until an event was signalled, or until `latest`.
void await(const EventDescriptor& event, Nanoseconds latest) noexcept {
  const Nanoseconds left = std::max(latest - monotonic_now(), Nanoseconds(0));
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec time{.tv_sec = static_cast<time_t>(whole.count()),
                      .tv_nsec = static_cast<long>((left - whole).count())};
  pollfd waiting{event.get(), POLLIN, 0};
  ::ppoll(&waiting, 1, &time, nullptr);
  event.clear();
}

}  // namespace

/// Returns the newer move with the mean force over both spans of time.
CallerDevice::Offer CallerDevice::joined(const Offer& older, const Offer& newer) noexcept {
  const double span = older.span + newer.span;
  if (!(span > 0.0)) return newer;
  const double share = older.span / span;
  return {newer.move, weighted(older.held, share, newer.held, 1.0 - share), span};
}

void CallerDevice::offer(const Move& move, Nanoseconds now) noexcept {
  const double span = exchanged_at_.count() > 0 ? seconds(now - exchanged_at_) : 0.0;
  waiting_ = joined(waiting_, {move, applied_, span});
  if (offers_.push(waiting_)) waiting_ = {};
  exchanged_at_ = now;
}

void CallerDevice::exchange(const Move& move, Nanoseconds now, const Command& applied) noexcept {
  offer(move, now);
  applies(applied);
}

bool CallerDevice::step(const Move& move, Nanoseconds now, Nanoseconds latest) noexcept {
  offer(move, now);
  const std::uint64_t number = begun_.fetch_add(1) + 1;
  begins_.signal();
  while (made_.load() < number) {
    if (monotonic_now() >= latest) return false;
    await(done_, latest);
  }
  return true;
}

void CallerDevice::ticked() noexcept {
  if (made_.exchange(taken_) != taken_) done_.signal();
}

/// A program that pauses is no device that fails: without a step the next reading says that the
/// hand was not moved.
bool CallerDevice::await_tick(Nanoseconds latest) noexcept {
  while (begun_.load() == taken_ && monotonic_now() < latest) await(begins_, latest);
  taken_ = begun_.load();
  return true;
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
