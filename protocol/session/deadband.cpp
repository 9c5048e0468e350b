#include "protocol/session/deadband.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

Vec3 part_extrapolated(const Vec3& part, const Vec3& rate, double time) noexcept {
  const double slope = part.dot(rate);
  // At this time t, the extrapolated part is perpendicular to `part`: part . (part + rate t) = 0.
  if (slope < 0.0) time = std::min(time, -part.squaredNorm() / slope);
  return part + time * rate;
}

}  // namespace

// The negated comparison makes NaN count as beyond the deadband.
bool beyond_deadband(const Vec3& value, const Vec3& expected, double fraction,
                     double floor) noexcept {
  return !(length(value - expected) <= fraction * length(value) + floor);
}

bool beyond_deadband(const Command& value, const Command& expected, double fraction) noexcept {
  return acts(value) != acts(expected) ||
         beyond_deadband(value.force(), expected.force(), fraction, kUnfeltForce) ||
         beyond_deadband(value.torque, expected.torque, fraction, kUnfeltTorque);
}

bool acts(const Command& command) noexcept { return !(command == Command{}); }

Command extrapolated(const Command& command, const Command& rates, double time) noexcept {
  if (!(time > 0.0) || !rates.finite()) return command;
  const Command later{part_extrapolated(command.elastic, rates.elastic, time),
                      part_extrapolated(command.frictional, rates.frictional, time),
                      part_extrapolated(command.torque, rates.torque, time)};
  return later.finite() ? later : command;
}

void CommandTrend::add(const Command& command, double elapsed) noexcept {
  time_ += elapsed;
  const bool same_contact = count_ > 0 && acts(command) == acts(entries_[newest_].command);
  if (!same_contact) count_ = 0;
  // At high rates, overwrite the newest entry until it is kSpacing later than the previous entry.
  const bool crowded = count_ > 1 && entries_[newest_].time - back(1).time < kSpacing;
  if (!crowded) {
    newest_ = (newest_ + 1) % kEntries;
    count_ = std::min(count_ + 1, kEntries);
  }
  entries_[newest_] = {time_, command};
}

Command CommandTrend::rates() const noexcept {
  if (count_ < 2) return {};
  // Use the oldest entry within kWindow. If only the newest entry is in the window, use the
  // previous entry.
  std::size_t steps = 1;
  while (steps + 1 < count_ && time_ - back(steps + 1).time <= kWindow) ++steps;
  const Entry& from = back(steps);
  const double span = time_ - from.time;
  if (!(span >= kLeast)) return {};
  const Command& to = entries_[newest_].command;
  return {(to.elastic - from.command.elastic) / span,
          (to.frictional - from.command.frictional) / span,
          (to.torque - from.command.torque) / span};
}

}  // namespace feltwire
