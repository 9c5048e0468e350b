#pragma once
// The numbers that a servo counts, tick by tick.

#include <array>
#include <cstdint>

#include "client/servo/zero_force_reason.hpp"
#include "core/base/histogram.hpp"

namespace feltwire {

/// Plain numbers of one run. Times in [ns], angles in [1e-6 deg] (whole numbers for the
/// histograms).
struct ServoStatistics {
  std::uint64_t samples = 0;        // made by hold()
  std::uint64_t datagrams = 0;      // newest samples of a due datagram: sent()
  std::uint64_t answered = 0;       // replies that came, each sample once
  std::uint64_t withheld = 0;       // datagrams that the server says it needed not answer
  std::uint64_t late = 0;           // of the answered, after more than kLate
  std::uint64_t replies_stale = 0;  // not newer than the reply in use: ignored
  std::uint64_t replies_refused =
      0;  // they answer no sample that was made, or are not finite or out of range
  std::uint64_t faded = 0;             // ticks at which an old command was faded, wholly or in part
  std::uint64_t device_faults = 0;     // readings or held forces that were faulty or not finite
  std::uint64_t jumps = 0;             // of these, readings that no hand can have moved to
  std::uint64_t stale_readings = 0;    // repeated readings: the force stayed held
  std::uint64_t forces_corrected = 0;  // readings with a held force that differs, by more than can
                                       // be felt, from the result of write()
  std::uint64_t bound_active = 0;      // ticks at which the bound changed the command
  std::uint64_t saturated = 0;         // ticks at which the device's limits changed it
  std::uint64_t account_cut = 0;  // ticks at which the port had not enough energy for all of it
  std::uint64_t refused = 0;      // ticks at which the bound got a command or movement out of range
  // Ticks at which these safety limits reduced the bound's force.
  std::uint64_t waiting = 0, ramped = 0, slewed = 0, too_fast = 0, force_limited = 0;
  std::uint64_t scene_resets =
      0;  // times that replies began to report that moving objects were put back
  // With a local model: received models, their surfaces, and ticks by the source of the command:
  // the model alone, the model and the reply, or the reply alone because the model did not reach.
  std::uint64_t whole_models = 0;  // models with a surface or solids that are here in full
  std::uint64_t models = 0, patches = 0, modelled = 0, half_modelled = 0, beyond_model = 0;
  std::uint64_t contact_cut = 0;  // of those beyond: the model's contact took too much work
  std::uint64_t most_work = 0;    // units of work (core/base/work_limit.hpp) of a tick's contact
  std::uint64_t hand_overs = 0;   // times that the use of the model alone began or ended
  std::array<std::uint64_t, kZeroForceReasons> no_force{};  // ticks by reason; `felt` too
  double max_force = 0.0;                                   // [N] held
  Histogram round_trip;       // [ns] from the sample's reading to the reply's arrival
  Histogram direction_error;  // [1e-6 deg] held force against its command
};

}  // namespace feltwire
