#include "client/servo/tick_watch.hpp"

#include <algorithm>

namespace feltwire {

Nanoseconds TickWatch::pause() const noexcept {
  return stands_still_ ? interval_ : std::min(interval_, most_pulling() - pulling_);
}

TickWatch::Verdict TickWatch::look(Nanoseconds now, std::uint64_t ticks, bool pulls) noexcept {
  const Nanoseconds counted =
      std::min(now - looked_.value_or(now - interval_), kMostCounted * interval_);
  looked_ = now;
  if (stands_still_) {
    since_ += counted;
    return since_ >= kGrace ? Verdict::gone : Verdict::stands_still;
  }
  const bool ticked = ticks != ticks_;
  ticks_ = ticks;
  still_ = ticked ? Nanoseconds(0) : still_ + counted;
  pulling_ = ticked || !pulls ? Nanoseconds(0) : pulling_ + counted;
  stands_still_ = pulling_ >= most_pulling() || still_ >= kIdle;
  return stands_still_ ? Verdict::stands_still : Verdict::ticks;
}

}  // namespace feltwire
