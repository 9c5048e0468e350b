#pragma once
// The force that a hand feels while its robot touches nothing.

#include <optional>
#include <vector>

#include "sim/studies/teleop/bench.hpp"

namespace feltwire::teleop {

struct LostContact {
  /// Share of the time without contact in which the hand feels more than kFelt.
  double felt = 0.0;
  /// [s] The longest time until the hand feels less than kFree, less half of the round trip. It
  /// counts from when the tool, without a touch, is as deep as where it lost the surface: before
  /// that, a surface that stands would give the same. A robot that touches again within kReacts
  /// has not lost the surface.
  double release = 0.0;

  static constexpr double kFelt = 0.3, kFree = 0.1;  // [N]
  static constexpr double kReacts = 0.03;            // [s]
};

/// Judges the samples from `first` to `last` (not included). `late`: half of the round trip in
/// samples; `period` [s]. None if the robot always touches.
std::optional<LostContact> lost_contact(const std::vector<BenchSample>& samples, std::size_t first,
                                        std::size_t last, std::size_t late, double period);

}  // namespace feltwire::teleop
