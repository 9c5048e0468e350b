#pragma once
// Which of the written commands is on the hand, where a device takes forces up late.

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// A device that takes forces up late by some ticks (ActuationSpec::late_ticks) either returns from
/// write() what is on the hand until then, or it cannot tell, and returns what it was given. Then
/// the command of so many ticks before is on the hand.
///
/// A device that returns neither holds less than it was given, now or when that comes on the hand.
/// Then several commands may be on the hand, and the energy of the worst of them counts.
class CommandDelay {
 public:
  /// `late` ticks, from 0 to kMostLateTicks.
  explicit CommandDelay(int late)
      : late_(static_cast<std::size_t>(std::clamp(late, 0, kMostLateTicks))) {}

  /// `given` was written, and write() returned `told`. Returns the command that is on the hand
  /// until the next write.
  const Command& written(const Command& given, const Command& told) noexcept {
    count_ = 0;
    if (late_ == 0) {
      add(told);
      return on_hand_.front();
    }
    const Write due = coming_.front();
    std::shift_left(coming_.begin(), coming_.begin() + static_cast<std::ptrdiff_t>(late_), 1);
    coming_[late_ - 1] = {given, told};
    const bool tells = same(told, due.given);
    if (tells || told != given) add(told);
    if (!tells) add(due.given);
    if (!tells && !same(due.told, due.given)) add(due.told);
    return on_hand_.front();
  }

  /// Only one command may be on the hand.
  bool certain() const noexcept { return count_ <= 1; }
  /// The command of those that may be on the hand which gives it the most energy over this
  /// movement.
  const Command& worst(const Vec3& displacement, const Vec3& rotation) const noexcept {
    const auto energy = [&](const Command& c) {
      return c.force().dot(displacement) + c.torque.dot(rotation);
    };
    const auto* const end = on_hand_.begin() + std::max<std::size_t>(count_, 1);
    return *std::max_element(on_hand_.begin(), end, [&](const Command& a, const Command& b) {
      return energy(a) < energy(b);
    });
  }
  /// Nothing is on the hand, and nothing is still to come.
  bool nothing_left() const noexcept {
    const auto none = [](const Command& c) { return c == Command{}; };
    return std::all_of(on_hand_.begin(), on_hand_.begin() + count_, none) &&
           std::all_of(coming_.begin(), coming_.begin() + late_,
                       [&](const Write& w) { return none(w.given) && none(w.told); });
  }

 private:
  struct Write {
    Command given, told;
  };
  /// Up to rounding: a mapping may stand between.
  static bool same(const Command& a, const Command& b) noexcept {
    constexpr double kRounding = 1e-9;
    const auto near = [](const Vec3& x, const Vec3& y) {
      return (x - y).squaredNorm() <= kRounding * kRounding * y.squaredNorm();
    };
    return near(a.force(), b.force()) && near(a.torque, b.torque);
  }
  void add(const Command& command) noexcept { on_hand_[count_++] = command; }

  std::size_t late_;
  std::array<Write, kMostLateTicks> coming_;  // the first is due next
  std::array<Command, 3> on_hand_;            // the first `count_` may be on the hand
  std::size_t count_ = 0;
};

}  // namespace feltwire
