#include "client/transport/contact_cost.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "core/base/time.hpp"
#include "core/base/units.hpp"
#include "core/prefetched_geometry/contact_trial.hpp"

namespace feltwire {
namespace {

/// Result of the fastest of several runs. Interruptions by the system slow down the other runs.
struct Timed {
  double time = 0.0;  // [s]
  std::uint64_t work = 0;
  bool cut = false;
};
Timed timed(const TrialTick& tick, std::uint64_t most, const ComputingClock& clock,
            double reading) {
  constexpr int kRuns = 3;
  Timed best;
  for (int run = 0; run < kRuns; ++run) {
    WorkLimit work(most);
    const Nanoseconds began = clock();
    tick.evaluate(work);
    const double took = std::max(0.0, seconds(clock() - began) - reading);
    if (run == 0 || took < best.time) best = {took, work.done(), work.cut()};
  }
  return best;
}

/// Returns the duration of a clock reading [s].
double reading_time(const ComputingClock& clock) {
  constexpr int kReadings = 8;
  Nanoseconds before = clock(), least = Nanoseconds::max();
  for (int n = 0; n < kReadings; ++n) {
    const Nanoseconds now = clock();
    least = std::min(least, now - before);
    before = now;
  }
  return seconds(least);
}

std::string microseconds(double time) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f us", kMicro * time);
  return text.data();
}

}  // namespace

Nanoseconds computing_time() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::seconds(now.tv_sec) + Nanoseconds(now.tv_nsec);
}

namespace {

/// Returns the longest time per unit of contact work [s]. Measures it in ticks with at most the
/// usual work.
double measured_unit(const FetchedScene& scene, double servo_period, const ComputingClock& clock,
                     double reading) {
  // Least work of a representative tick. The overhead dominates a tick with less work.
  constexpr std::uint64_t kManyUnits = 1024;
  constexpr double kSlowest = 4.0 * kUsualUnit;  // [s] largest result if all ticks have less work
  const std::uint64_t most = units_within(contact_budget(servo_period));
  double time = 0.0, work = 0.0, of_long_ticks = 0.0;
  try_contact(scene, servo_period, [&](const TrialTick& tick) {
    const Timed took = timed(tick, most, clock, reading);
    const auto units = static_cast<double>(took.work);
    time += took.time;
    work += units;
    if (took.work >= kManyUnits) of_long_ticks = std::max(of_long_ticks, took.time / units);
    return !took.cut;
  });
  if (of_long_ticks > 0.0) return std::max(kUsualUnit, of_long_ticks);
  return work > 0.0 ? std::clamp(time / work, kUsualUnit, kSlowest) : kUsualUnit;
}

}  // namespace

ContactCost contact_cost(const FetchedScene& scene, double servo_period,
                         const ComputingClock& clock) {
  const double budget = contact_budget(servo_period);
  const double reading = reading_time(clock);
  ContactCost cost;
  cost.unit = measured_unit(scene, servo_period, clock, reading);
  const std::uint64_t most = units_within(budget, cost.unit);
  try_contact(scene, servo_period, [&](const TrialTick& tick) {
    const Timed took = timed(tick, most, clock, reading);
    if (took.time > cost.longest || took.cut) {
      cost.longest = took.time;
      cost.object = tick.object;
    }
    cost.cut = took.cut;
    return !took.cut && took.time <= budget;
  });
  return cost;
}

std::optional<std::string> too_costly(const ContactCost& cost, double servo_period) {
  const double budget = contact_budget(servo_period);
  if (!cost.cut && cost.longest <= budget) return std::nullopt;
  return "this client does not compute the contact itself: near object " +
         std::to_string(cost.object) + " it takes more than the " + microseconds(budget) +
         " that a tick has for it (a quarter of the servo period)" +
         (cost.longest > budget ? ", " + microseconds(cost.longest) : std::string()) +
         "; the forces of the replies are used, and come as late as the network; fewer triangles, "
         "points of the tool or objects, or a lower --rate, would let it";
}

}  // namespace feltwire
