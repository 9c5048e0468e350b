#pragma once
// The numbers that a servo counts, tick by tick.

#include <array>
#include <cstdint>

#include "client/servo/zero_force_reason.hpp"
#include "core/base/histogram.hpp"

namespace feltwire {

/// Counts of the device's readings.
struct DeviceCounts {
  std::uint64_t faults = 0;            // readings or held forces that were faulty or not finite
  std::uint64_t jumps = 0;             // of these, readings that no hand can have moved to
  std::uint64_t stale_readings = 0;    // repeated readings: the force stayed held
  std::uint64_t forces_corrected = 0;  // readings with a held force that differs, by more than can
                                       // be felt, from the result of write()
};

/// Counts of the datagrams with samples, and of their replies.
struct ReplyCounts {
  std::uint64_t datagrams = 0;  // newest samples of a due datagram: ReplyIntake::sent()
  std::uint64_t answered = 0;   // replies that came, each sample once
  std::uint64_t withheld = 0;   // datagrams that the server says it needed not answer
  std::uint64_t late = 0;       // of the answered, after more than kLate
  std::uint64_t stale = 0;      // not newer than the reply in use: ignored
  std::uint64_t refused = 0;    // they answer no sample that was made, or are not finite or out of
                                // range
  std::uint64_t scene_resets = 0;  // times that replies began to report that moving objects were
                                   // put back
  Histogram round_trip;            // [ns] from the sample's reading to the reply's arrival
};

/// Counts of the local model. The ticks are counted by the source of their command.
struct LocalModelCounts {
  std::uint64_t received = 0;      // models
  std::uint64_t whole = 0;         // of these, with a surface or solids that are here in full
  std::uint64_t patches = 0;       // surfaces in all of them
  std::uint64_t from_model = 0;    // ticks: the model alone
  std::uint64_t from_both = 0;     // ticks: the model and the reply
  std::uint64_t beyond_reach = 0;  // ticks: the reply alone, because the model did not reach
  std::uint64_t contact_cut = 0;   // of those beyond: the model's contact took too much work
  std::uint64_t most_work = 0;     // units of work (core/base/work_limit.hpp) of a tick's contact
  std::uint64_t hand_overs = 0;    // times that the use of the model alone began or ended
};

/// Ticks at which a stage of the force law changed the command.
struct ForceLawCounts {
  std::uint64_t bound_active = 0;  // the bound
  std::uint64_t saturated = 0;     // the device's limits
  std::uint64_t account_cut = 0;   // the port had not enough energy for all of it
  std::uint64_t refused = 0;       // the bound got a command or movement out of range
  // The safety limits reduced the bound's force.
  std::uint64_t waiting = 0, ramped = 0, slewed = 0, too_fast = 0, force_limited = 0;
};

/// Plain numbers of one run. Angles are whole numbers of [1e-6 deg] for the histogram.
struct ServoStatistics {
  std::uint64_t samples = 0;  // made by hold()
  std::uint64_t faded = 0;    // ticks at which an old command was faded, wholly or in part
  DeviceCounts device;
  ReplyCounts replies;
  LocalModelCounts local_model;
  ForceLawCounts law;
  std::array<std::uint64_t, kZeroForceReasons> no_force{};  // ticks by reason; `felt` too
  double max_force = 0.0;                                   // [N] held
  Histogram direction_error;  // [1e-6 deg] held force against its command
};

}  // namespace feltwire
