#pragma once
// Maps the places of several hands to one target of a robot.

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/teleoperation/clutch_offset.hpp"

namespace feltwire {

/// Several hands on one target, each with a share a_i > 0, sum a_i = 1:
///   x_t = x_t0 + s sum a_i (x_i - x_i0)
/// Each hand has a ClutchOffset of scale s a_i, and what the others move shifts it. So a surface of
/// the robot is told to each hand where that hand alone would have to move the target to it, with
/// the stiffness that its own movement meets: every hand feels the force on the robot,
/// times f. The hand
/// with the largest share turns the robot, the first of equals.
///
/// begin() starts anew from the target that there is: for any hands, shares and poses the first
/// target after it is equal to that one, exactly in position.
class SharedClutchOffset {
 public:
  static constexpr std::size_t kMost = 4;

  /// As for ClutchOffset.
  explicit SharedClutchOffset(double scale, double force_scale = 1.0)
      : scale_(scale), force_scale_(force_scale) {
    clutches_.fill(ClutchOffset(scale, force_scale));
  }

  struct Part {
    double weight = 0.0;  // its share is this over the sum; 0: it does not lead
    Pose hand;            // where it is, less its offset
  };
  using Parts = std::array<Part, kMost>;

  /// From now on these hands lead, from where they are, and the target is `target`. Precondition:
  /// the weights are finite and not negative, the orientations unit.
  void begin(const Parts& parts, const Pose& target) noexcept {
    double sum = 0.0;
    for (const Part& part : parts) sum += part.weight;
    turns_ = kMost;
    double largest = 0.0;
    for (std::size_t i = 0; i < kMost; ++i) {
      shares_[i] = parts[i].weight > 0.0 ? parts[i].weight / sum : 0.0;
      if (!(shares_[i] > 0.0)) continue;
      clutches_[i] = ClutchOffset(scale_ * shares_[i], force_scale_);
      clutches_[i].engage(parts[i].hand, target);
      if (shares_[i] > largest) turns_ = i;
      largest = std::max(largest, shares_[i]);
    }
  }

  /// The target that hand `i` asks for; `now` is the target that there is. Precondition: it leads.
  Pose asked(std::size_t i, const Pose& hand, const Pose& now) const noexcept {
    Pose target = clutches_[i].target(hand);
    if (i != turns_) target.orientation = now.orientation;
    return target;
  }
  /// Hand `i` has moved the target by `moved` [m]; limits changed what it asked for by `corrected`.
  void settle(std::size_t i, const Vec3& moved, const Vec3& corrected) noexcept {
    for (std::size_t other = 0; other < kMost; ++other)
      if (other != i && shares_[other] > 0.0) clutches_[other].shift(moved);
    clutches_[i].shift(corrected);
  }

  /// As ClutchOffset::align(), of the hand that turns the robot; nothing for another one.
  void align(std::size_t i, const Quaternion& offset, double angle) noexcept {
    if (i == turns_) clutches_[i].align(offset, angle);
  }

  const ClutchOffset& clutch(std::size_t i) const noexcept { return clutches_[i]; }
  double share(std::size_t i) const noexcept { return shares_[i]; }  // 0: it does not lead
  /// The hand that turns the robot; kMost: nobody leads.
  std::size_t turns() const noexcept { return turns_; }

 private:
  double scale_, force_scale_;
  std::array<ClutchOffset, kMost> clutches_{ClutchOffset(1.0), ClutchOffset(1.0), ClutchOffset(1.0),
                                            ClutchOffset(1.0)};
  std::array<double, kMost> shares_{};
  std::size_t turns_ = kMost;
};

}  // namespace feltwire
