#pragma once
// The lag of a plant's amplifier as a device's specification tells it.

#include "client/hands/plant.hpp"
#include "core/bounding/lagging_forces.hpp"

namespace feltwire {

/// The bound of an amplifier's lag that a device tells: a filter without delay is one of its kind,
/// anything else may end at the latest time of its response.
inline MotorLag lag_of(const Plant::Amplifier& amplifier) {
  const double latest = amplifier.delay + amplifier.jitter;
  if (latest == 0.0) return {.time = amplifier.lag, .kind = LagKind::filter};
  return {.time = latest + MotorLag::kRest * amplifier.lag};
}

}  // namespace feltwire
