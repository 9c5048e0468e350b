#include "client/devices/simulated_device.hpp"

namespace feltwire {

SimulatedDevice::SimulatedDevice(const SimulatedHandOptions& options)
    : HandDevice(options.spec, options.hand),
      options_(options),
      motion_(options.task),
      turn_(options.wrist, options.task) {
  place(motion_.position(0.0));
}

void SimulatedDevice::begin(const Vec3& position, const Vec3& normal) {
  if (!options_.own_center) options_.task.center = position;
  if (!options_.own_normal) set_normal(options_.task, normal);
  motion_ = IntendedMotion(options_.task);
  turn_ = IntendedTurn(options_.wrist, options_.task);
  place(motion_.position(0.0));
}

DeviceReading SimulatedDevice::read(Nanoseconds now) noexcept {
  DeviceReading reading = HandDevice::read(now);
  reading.deadman = options_.leads_from && time_ >= *options_.leads_from;
  return reading;
}

}  // namespace feltwire
