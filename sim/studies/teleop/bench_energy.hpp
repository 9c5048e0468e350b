#pragma once
// The energy at the two ends of a bench, which no law knows.

#include <algorithm>
#include <cmath>

namespace feltwire::teleop {

/// [J] The largest net energy that each contact gave to the robot, summed over the contacts.
struct ContactPush {
  double pushed = 0.0;

  /// A step of the robot: `work` [J] of the contact's force on it. Without a touch a contact ends.
  void add(bool touches, double work) {
    given_ = touches ? given_ + work : 0.0;
    most_ = touches ? most_ : 0.0;
    pushed += std::max(0.0, given_ - most_);
    most_ = std::max(most_, given_);
  }

 private:
  double given_ = 0.0, most_ = 0.0;
};

/// [J] The most that the hand was given beyond what the device burned, as the encoder shows it, and
/// what the environment had pushed until then.
class HandEnergy {
 public:
  /// A sample: `work` [J] on the hand, the energies `burned` [J] in it and `pushed` [J] since the
  /// begin.
  void add(double work, double burned, double pushed) {
    delivered_ += work;
    burned_ += burned;
    exchanged_ += std::abs(work);
    made_ = std::max(made_, delivered_ - burned_ - pushed);
  }
  double made() const {
    // Sums of this length round by no more.
    constexpr double kRounding = 1e-12;
    return made_ > kRounding * exchanged_ ? made_ : 0.0;
  }

 private:
  double delivered_ = 0.0, burned_ = 0.0, exchanged_ = 0.0, made_ = 0.0;
};

}  // namespace feltwire::teleop
