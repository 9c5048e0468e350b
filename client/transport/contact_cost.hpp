#pragma once
// Measures what contact with fetched geometry costs on this machine, before the servo uses it.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/base/types.hpp"
#include "core/local_model/contact_budget.hpp"
#include "core/local_model/prefetched_geometry.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Returns the time that the calling thread has computed so far. What other threads take does not
/// count.
using ComputingClock = std::function<Nanoseconds()>;
Nanoseconds computing_time() noexcept;

struct ContactCost {
  double longest = 0.0;      // [s] of one tick, the costliest that was tried
  bool cut = false;          // a tick was cut off: its units do not fit its share of the period
  std::uint16_t object = 0;  // that it was near, by its number in the scene
  double unit = kUsualUnit;  // [s] that a unit of work takes at most; never less than kUsualUnit
};

/// Tries ticks where the contact is likely to cost the most
/// (core/prefetched_geometry/trial_ways.hpp), first to measure a unit, then with the limit that
/// follows from it, up to the first tick that takes too long. `servo_period` [s].
ContactCost contact_cost(const FetchedScene& scene, double servo_period,
                         const ComputingClock& clock);

/// Why the contact is too costly for a servo of this period [s], with the remedy; empty: it is not.
std::optional<std::string> too_costly(const ContactCost& cost, double servo_period);

}  // namespace feltwire
