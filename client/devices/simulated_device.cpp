#include "client/devices/simulated_device.hpp"

namespace feltwire {

SimulatedDevice::SimulatedDevice(const SimulatedHandOptions& options)
    : HandDevice(options.spec, options.hand), options_(options), motion_(options.task) {
  place(motion_.position(0.0));
}

void SimulatedDevice::begin(const Vec3& position, const Vec3& normal) {
  if (!options_.own_center) options_.task.center = position;
  if (!options_.own_normal) set_normal(options_.task, normal);
  motion_ = IntendedMotion(options_.task);
  place(motion_.position(0.0));
}

}  // namespace feltwire
