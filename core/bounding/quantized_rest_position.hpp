#pragma once
// The assumed place of a hand that rests between two readings of an encoder.

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/base/types.hpp"

namespace feltwire {

/// A hand that presses on a stiff wall finds no reading of the encoder at which the wall balances
/// it: one quantum q less pushes too weakly, one more too strongly. So it moves to and fro between
/// two readings, as often as its mass and the servo allow, and each time takes k q^2 out of the
/// account (docs/bounding.md, "A resting hand"). This class lets it rest, axis by axis: once all
/// readings for kRest were two neighbours, the scene is asked at one place between them. That place
/// begins at their mean and moves by kStep of the way to each new reading, until the wall balances
/// the hand there. A third reading ends the rest.
class QuantizedRestPosition {
 public:
  static constexpr double kRest = 0.05;  // [s]
  static constexpr double kMean = 0.02;  // [s] over which the mean is taken
  static constexpr double kStep = 0.75;

  /// q [m], the encoder quantum of each world axis.
  explicit QuantizedRestPosition(double quantum) : two_readings_(1.5 * quantum) {}

  void moved(const Vec3& displacement, double time) noexcept {
    for (std::size_t i = 0; i < axes_.size(); ++i)
      axes_[i].moved(displacement[static_cast<int>(i)], time, two_readings_);
  }

  /// [m] from the reading after `displacement` to the place; the place ahead on an axis where the
  /// hand does not rest: `ahead` samples ahead (core/bounding/midpoint.hpp).
  Vec3 offset(const Vec3& displacement, double ahead) const noexcept {
    Vec3 offset = ahead * displacement;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      if (!axes_[i].rests()) continue;
      Axis axis = axes_[i];
      axis.moved(displacement[static_cast<int>(i)], 0.0, two_readings_);
      if (axis.rests()) offset[static_cast<int>(i)] = axis.place;
    }
    return offset;
  }

 private:
  /// Lengths are measured from the last reading.
  struct Axis {
    double lowest = 0.0, highest = 0.0;  // [m] readings since the last third one
    double place = 0.0;                  // [m]
    double time = 0.0;                   // [s] since then

    bool rests() const noexcept { return time >= kRest; }
    void moved(double by, double more, double two_readings) noexcept {
      place -= by;
      if (!rests())
        place *= std::max(0.0, 1.0 - more / kMean);
      else if (by != 0.0)
        place *= 1.0 - kStep;
      time += more;
      lowest = std::min(lowest - by, 0.0);
      highest = std::max(highest - by, 0.0);
      if (!(highest - lowest <= two_readings)) *this = {};
    }
  };

  double two_readings_;  // [m] more than one quantum, less than two
  std::array<Axis, 3> axes_{};
};

}  // namespace feltwire
