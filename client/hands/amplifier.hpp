#pragma once
// The amplifier of a simulated device: what the motor gives of the forces that were written.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/hands/plant.hpp"

namespace feltwire {

/// Plant::Amplifier for one vector, force [N] or torque [N m]. Exact at every time: the times at
/// which forces arrive are not rounded to steps. Nothing allocates after construction.
class Amplifier {
 public:
  /// Precondition: validate() passed.
  Amplifier(const Plant::Amplifier& plant, std::uint64_t seed);

  /// The vector was written at `time` [s]. Times do not fall.
  void write(double time, const Vec3& written) noexcept;
  /// Moves from `begin` to `begin` + `span` [s], and returns the mean of the output over it. Each
  /// call begins where the one before ended.
  Vec3 mean(double begin, double span) noexcept;
  /// The output now.
  const Vec3& output() const noexcept { return output_; }

 private:
  struct Written {
    double arrives;  // [s]
    Vec3 vector;
  };
  static constexpr std::size_t kRoom = 4096;  // on their way: 0.1 s at 40 kHz
  void take_arrived(double now) noexcept;
  Vec3 settle(double span) noexcept;
  Written& waiting(std::size_t i) noexcept { return waiting_[(first_ + i) % kRoom]; }

  Plant::Amplifier plant_;
  std::uint64_t seed_, writes_ = 0;
  Vec3 target_ = Vec3::Zero(), output_ = Vec3::Zero();
  std::vector<Written> waiting_;  // a ring, by rising times of arrival
  std::size_t first_ = 0, count_ = 0;
  double span_ = -1.0, left_ = 0.0;  // [s], and the share exp(-span / lag) that is left after it
};

}  // namespace feltwire
