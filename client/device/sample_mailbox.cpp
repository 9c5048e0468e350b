#include "client/device/sample_mailbox.hpp"

#include <poll.h>

#include <algorithm>

#include "client/device/held_command.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/poll_until.hpp"

namespace feltwire {

void Wake::wait_until(Nanoseconds latest) const noexcept {
  poll_until(signal_.get(), POLLIN, latest);
  signal_.clear();
}

void Wake::wait() const noexcept {
  pollfd waiting{signal_.get(), POLLIN, 0};
  ::poll(&waiting, 1, -1);
  signal_.clear();
}

Command SampleMailbox::exchange(DeviceReading reading, Nanoseconds patience) noexcept {
  const Nanoseconds now = monotonic_now();
  const double span = seconds(now - offered_at_);
  if (number_ > 0 && span > 0.0) {
    const double late = std::clamp(seconds(applied_at_ - offered_at_) / span, 0.0, 1.0);
    reading.held = weighted(before_, late, applied_, 1.0 - late);
  }
  offered_at_ = now;
  before_ = applied_;
  number_ += 2;
  state_.store(number_, std::memory_order_release);
  bool answered = false;
  if (offers_.push({reading, span, number_})) {
    servo_wake_.set();
    const Nanoseconds latest = now + patience;
    while (!answered && !released() && monotonic_now() < latest) {
      device_wake_.wait_until(latest);
      answered = state_.load(std::memory_order_acquire) == number_ + 1;
    }
  }
  std::uint64_t standing = number_;
  answered = !state_.compare_exchange_strong(standing, kClosed, std::memory_order_acq_rel);
  if (answered) applied_ = command_;
  repeated_ = answered ? 0 : repeated_ + 1;
  if (released() || repeated_ > most_repeated_) applied_ = {};
  applied_at_ = monotonic_now();
  return applied_;
}

/// Takes all readings that exchange() offered since the last call, and stores the newest reading in
/// news_. Its held force is the time average over these readings, and a fault of any of them makes
/// it faulty. Returns true if a reading arrived.
bool SampleMailbox::take() noexcept {
  Offer offer;
  while (offers_.pop(offer)) {
    if (news_.held && offer.reading.held && news_span_ + offer.span > 0.0) {
      const double share = news_span_ / (news_span_ + offer.span);
      offer.reading.held = weighted(*news_.held, share, *offer.reading.held, 1.0 - share);
    }
    news_span_ += offer.span;
    offer.reading.ok &= news_.ok;
    news_ = offer.reading;
    taken_ = offer.number;
  }
  return news_.fresh;
}

bool SampleMailbox::await(Nanoseconds latest) noexcept {
  while (!take()) {
    if (released() || monotonic_now() >= latest) return false;
    servo_wake_.wait_until(latest);
  }
  return true;
}

DeviceReading SampleMailbox::newest() noexcept {
  take();
  DeviceReading newest = news_;
  if (newest.fresh && newest.held) expected_ = *newest.held;
  news_ = {.pose = {}, .fresh = false};
  news_span_ = 0.0;
  return newest;
}

Command SampleMailbox::write(const Command& on_hand) noexcept {
  if (released()) return {};
  if (taken_ == 0) return expected_;
  std::uint64_t standing = taken_;
  const std::uint64_t answer = taken_ + 1;
  taken_ = 0;
  command_ = on_hand;  // exchange() uses it only if the next line succeeds
  if (!state_.compare_exchange_strong(standing, answer, std::memory_order_acq_rel))
    return expected_;
  device_wake_.set();
  expected_ = on_hand;
  return on_hand;
}

}  // namespace feltwire
