#include "client/servo/tick_watch.hpp"

namespace feltwire {

TickWatch::Verdict TickWatch::look(std::uint64_t ticks, bool pulls) noexcept {
  if (stands_still_) {
    since_ += interval_;
    return since_ >= kGrace ? Verdict::gone : Verdict::stands_still;
  }
  const bool ticked = ticks != ticks_;
  ticks_ = ticks;
  still_ = ticked ? Nanoseconds(0) : still_ + interval_;
  pulling_ = ticked || !pulls ? Nanoseconds(0) : pulling_ + interval_;
  // The last tick was up to an interval before the first look that missed one.
  stands_still_ = pulling_ >= (kLooks - 1) * interval_ || still_ >= kIdle;
  return stands_still_ ? Verdict::stands_still : Verdict::ticks;
}

}  // namespace feltwire
