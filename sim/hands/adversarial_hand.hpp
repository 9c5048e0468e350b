#pragma once
// The worst hand for a port: it presses, and then takes as much energy as it can.

#include <atomic>

#include "client/device/device.hpp"

namespace feltwire {

/// The place and way of its press.
struct TakingTask {
  Vec3 start = Vec3::Zero();     // [m] outside the surface
  Vec3 inward = -Vec3::UnitZ();  // unit, into the surface
  double depth = 0.01;           // [m] how far it goes from the start
  double speed = 0.02;           // [m/s] there and back
};

/// Goes in at `speed`, and from there moves with the force that it knows is held, v = f / (2 b). Of
/// the energy f v h - b v^2 h that it takes, this is the most that one hold can give, f^2 h / (4
/// b), which is all that the contact frame stores for a force f. When the force is gone it goes
/// back to its start, and in again. Kinematic: no force moves it, and it is read exactly.
class AdversarialHand final : public Device {
 public:
  /// Precondition: the damping of `spec` is above zero in every direction.
  AdversarialHand(const TakingTask& task, const DeviceSpec& spec)
      : task_(task), spec_(spec), position_(task.start) {}

  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override;
  void release() noexcept override { released_.store(true); }

 private:
  enum class Phase : std::uint8_t { in, taking, back };
  bool go_to(const Vec3& goal, double step) noexcept;

  TakingTask task_;
  DeviceSpec spec_;
  Vec3 position_;              // [m]
  Vec3 force_ = Vec3::Zero();  // [N] held
  std::atomic<bool> released_{false};
  Phase phase_ = Phase::in;
  bool started_ = false;
  Nanoseconds last_{0};
};

}  // namespace feltwire
