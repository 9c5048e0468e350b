#include "client/servo/stall_detector.hpp"

#include <algorithm>

namespace feltwire {

double let_go_time(double servo_period, double hold_time, double asked, bool real_time) noexcept {
  const double usual = (real_time ? kLateTicks : kLateTicksWithoutRealTime) * servo_period;
  return std::max(std::min(asked > 0.0 ? asked : usual, hold_time), kLeastLateTicks * servo_period);
}

Nanoseconds StallDetector::pause() const noexcept {
  constexpr int kShortest = 8;  // a pause is at least late_ / kShortest
  if (stands_still_) return late_;
  return std::clamp(limit_ - pulling_, late_ / kShortest, late_);
}

StallDetector::Verdict StallDetector::look(Nanoseconds now, const SignsOfLife& life) noexcept {
  const Nanoseconds most = pause() + late_;
  const Nanoseconds slept = std::max(now - looked_.value_or(now), Nanoseconds(0));
  looked_ = now;
  if (stands_still_) {
    since_ += std::min(slept, most);
    return since_ >= kGrace ? Verdict::gone : Verdict::stands_still;
  }
  const bool lives = life.calls != calls_, stopped = slept > most;
  calls_ = life.calls;
  limit_ = life.awaits ? hold_ : late_;
  if (lives) {
    // The servo ticked since the last look. A later stop of the whole program does not count.
    still_ = stopped ? Nanoseconds(0) : std::clamp(now - life.tick, Nanoseconds(0), slept);
    pulling_ = life.pulls ? still_ : Nanoseconds(0);
    forgiven_ = stopped;
  } else if (stopped && !forgiven_) {
    pulling_ = Nanoseconds(0);
    forgiven_ = true;
  } else {
    still_ += std::min(slept, most);
    pulling_ = life.pulls ? pulling_ + std::min(slept, most) : Nanoseconds(0);
  }
  stands_still_ = pulling_ >= limit_ || still_ >= kIdle;
  return stands_still_ ? Verdict::stands_still : Verdict::ticks;
}

}  // namespace feltwire
