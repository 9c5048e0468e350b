#include "server/scene/fair_share.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace feltwire {

FairShare::FairShare(std::size_t sessions) : uses_(sessions) {}

std::uint32_t FairShare::add(double interval) noexcept {
  std::size_t free = 0;
  while (free + 1 < uses_.size() && uses_[free].here) ++free;
  uses_[free] = {.here = true, .interval = interval};
  end_ = std::max(end_, free + 1);
  return static_cast<std::uint32_t>(free);
}

void FairShare::remove(std::uint32_t session) noexcept {
  Use& use = uses_[session];
  use = {.spent = use.spent + use.fresh};  // the used time of an ended session still counts
}

void FairShare::charge(Nanoseconds spent) noexcept {
  const double time = std::clamp(seconds(spent), 0.0, kLongest);
  const double each = taken_ == 0 ? 0.0 : time / static_cast<double>(taken_);
  for (std::size_t i = 0; i < recent_count_; ++i) {
    Use& use = uses_[recent_[i]];
    use.fresh += each;
    use.time += each;
    ++use.datagrams;
  }
  other_.fresh += time - each * static_cast<double>(recent_count_);
  recent_count_ = taken_ = 0;
}

void FairShare::balance_now(Nanoseconds now) noexcept {
  const double passed = last_ ? std::max(0.0, seconds(now - *last_)) : 0.0;
  last_ = now;
  const double left = std::exp(-passed / kWindow);
  other_.spent = left * other_.spent + other_.fresh;
  other_.fresh = 0.0;
  for (std::size_t i = 0; i < end_; ++i) {
    Use& use = uses_[i];
    use.spent = left * use.spent + use.fresh;
    use.fresh = 0.0;
    if (!use.here) other_.spent += std::exchange(use.spent, 0.0);
  }
  find_level();
  look_for_slow(now);
}

/// Computes level_, the computing time that a session may use (max-min fairness). Begins with equal
/// shares. Divides the time that some sessions do not use among the others, until the level no
/// longer rises.
void FairShare::find_level() noexcept {
  level_ = std::numeric_limits<double>::infinity();
  const double room = std::max(kMost * kWindow - other_.spent, kLeast * kWindow);
  double all = 0.0;
  std::size_t sessions = 0;
  for (std::size_t i = 0; i < end_; ++i) {
    all += uses_[i].spent;
    sessions += uses_[i].here ? 1 : 0;
  }
  load_ = (all + other_.spent) / kWindow;
  if (all <= room) return;
  level_ = room / static_cast<double>(sessions);
  for (;;) {
    double below = 0.0;
    std::size_t above = 0;
    for (std::size_t i = 0; i < end_; ++i) {
      if (!uses_[i].here) continue;
      if (uses_[i].spent <= level_)
        below += uses_[i].spent;
      else
        ++above;
    }
    if (above == 0) return;
    const double next = (room - below) / static_cast<double>(above);
    if (!(next > level_)) return;
    level_ = next;
  }
}

void FairShare::look_for_slow(Nanoseconds now) noexcept {
  if (!second_began_) second_began_ = now;
  if (seconds(now - *second_began_) < kLook) return;
  second_began_ = now;
  for (std::size_t i = 0; i < end_; ++i) {
    Use& use = uses_[i];
    // A datagram that was dropped (`shed`) takes almost no time, so leave it out of the mean.
    const auto answers = static_cast<double>(use.datagrams - std::min(use.shed, use.datagrams));
    const double answer = answers > 0.0 ? use.time / answers : 0.0;
    if (use.here && answer > use.interval) slow_ = {slow_.seconds + 1, answer, use.interval};
    use.time = 0.0;
    use.datagrams = use.shed = 0;
  }
}

}  // namespace feltwire
