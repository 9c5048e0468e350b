#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/base/time.hpp"
#include "core/teleoperation/lead_engagement.hpp"

namespace feltwire {

/// The states between a hand and a robot during a run, for its report. Never allocates.
class LinkStates {
 public:
  /// So many changes are kept; later ones are counted only.
  static constexpr std::size_t kMost = 200;
  struct Change {
    double time = 0.0;  // [s] since the first state
    LinkState state = LinkState::disabled;
    std::uint8_t seat = 0;  // of the robot
  };

  /// The state at `now`, the first one or a later one.
  void take(LinkState state, std::uint8_t seat, Nanoseconds now) noexcept {
    if (count_ == 0) begin_ = now;
    if (count_ > 0 && state == last_.state && seat == last_.seat) return;
    last_ = {seconds(now - begin_), state, seat};
    if (count_ < kMost) kept_[count_] = last_;
    ++count_;
  }

  /// The first state, and each that was another one than that before.
  std::span<const Change> changes() const noexcept {
    return {kept_.data(), std::min(count_, kMost)};
  }
  /// The number of changes that were not kept.
  std::size_t left_out() const noexcept { return count_ - changes().size(); }

 private:
  std::array<Change, kMost> kept_{};
  std::size_t count_ = 0;
  Change last_;
  Nanoseconds begin_{0};
};

}  // namespace feltwire
