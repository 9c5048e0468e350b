#include "client/hands/simulated_device.hpp"

#include <cmath>
#include <limits>

namespace feltwire {

SimulatedDevice::SimulatedDevice(const SimulatedHandOptions& options)
    : HandDevice(options.spec, options.hand, options.plant),
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
  const double since =
      time_ - options_.presses_at.value_or(std::numeric_limits<double>::infinity());
  const bool let_go = std::abs(since) < SimulatedHandOptions::kLetGo;
  reading.deadman = options_.leads_from && time_ >= *options_.leads_from && !let_go;
  reading.buttons = since >= 0.0 && since < SimulatedHandOptions::kPress ? 1u : 0u;
  return reading;
}

}  // namespace feltwire
