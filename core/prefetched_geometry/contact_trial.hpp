#pragma once
// Tries the contact with fetched geometry before a servo uses it. It reads no clock: the caller
// measures.

#include <cstdint>
#include <functional>

#include "core/local_model/prefetched_geometry.hpp"

namespace feltwire {

/// A tick of a trial.
struct TrialTick {
  std::uint16_t object = 0;  // that the tool goes to, by its number in the scene
  /// Evaluates the contact of this tick within a limit. It may be called several times: each call
  /// begins with the same memory.
  const std::function<void(WorkLimit&)>& evaluate;
};

/// Calls visit(tick) for ticks of tools on the trial ways of the scene, until it returns false. A
/// tick in which `evaluate` was not called leaves the tool as it was. `servo_period` [s].
void try_contact(const FetchedScene& scene, double servo_period,
                 const std::function<bool(const TrialTick&)>& visit);

}  // namespace feltwire
