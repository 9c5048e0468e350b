#pragma once
// The last movements to and fro of a hand along a line.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace feltwire {

/// The last N movements of a hand, each from one change of direction to the next.
template <std::size_t N>
class ReversalHistory {
 public:
  /// The hand moved by `way` [m] over `time` [s]. A change of direction counts once it has moved
  /// back by more than `swing` > 0 [m]. True where one counts now.
  bool moved(double way, double time, double swing) noexcept {
    now_ += time;
    place_ += way;
    highest_ = direction_ < 0 ? highest_ : std::max(highest_, place_);
    lowest_ = direction_ > 0 ? lowest_ : std::min(lowest_, place_);
    if (direction_ >= 0 && place_ < highest_ - swing) {
      turned(-1, highest_, swing);
    } else if (direction_ <= 0 && place_ > lowest_ + swing) {
      turned(1, lowest_, swing);
    } else {
      return false;
    }
    return true;
  }

  /// The movements since the beginning or restart(), N at most.
  std::size_t count() const noexcept { return counted_; }
  /// [m] of the movement i, 0 for the newest. Precondition: i < count().
  double length(std::size_t i) const noexcept { return newest(i).length; }
  /// [s] since the movement i ended. Precondition: i < count().
  double since(std::size_t i) const noexcept { return now_ - newest(i).end; }
  /// Counts from 0 again.
  void restart() noexcept { counted_ = 0; }

 private:
  struct Movement {
    double end = 0.0;     // [s]
    double length = 0.0;  // [m]
  };
  const Movement& newest(std::size_t i) const noexcept {
    return movements_[(next_ + N - 1 - i) % N];
  }
  void turned(int direction, double at, double swing) noexcept {
    movements_[next_] = {now_, std::max(swing, std::abs(at - turned_at_))};
    next_ = (next_ + 1) % N;
    if (counted_ < N) ++counted_;
    direction_ = direction;
    highest_ = lowest_ = place_;
    turned_at_ = at;
  }

  double now_ = 0.0;                     // [s]
  double place_ = 0.0;                   // [m] since the beginning
  double highest_ = 0.0, lowest_ = 0.0;  // [m] since the last change of direction
  double turned_at_ = 0.0;               // [m]
  int direction_ = 0;                    // of the motion; 0: not known yet
  std::array<Movement, N> movements_{};  // a ring
  std::size_t next_ = 0;                 // the index of the oldest
  std::size_t counted_ = 0;
};

}  // namespace feltwire
