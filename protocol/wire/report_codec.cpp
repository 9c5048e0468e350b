#include "protocol/wire/report_codec.hpp"

#include <algorithm>

#include "protocol/session/client_change.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kFlagAccount = 1u << 0, kFlagChangeRefused = 1u << 1;
constexpr unsigned kChangeShift = 2;     // first of 6 bits for the number of a change
constexpr unsigned kLateTicksShift = 8;  // first of 24 bits for the count of late ticks

}  // namespace

wire::HandReport wire_report(const HandReport& report) {
  return {report.reasons,
          (report.has_account ? kFlagAccount : 0) |
              (report.change_refused ? kFlagChangeRefused : 0) |
              std::uint32_t{report.change} << kChangeShift | report.late_ticks << kLateTicksShift,
          float32(report.balance), float32(report.round_trip), float32(report.hand_damping)};
}

wire::HandTimes wire_times(const HandTimes& times) {
  return wire::HandTimes(
      flatbuffers::span<const std::uint16_t, HandTimes::kClasses>(times.wakeups),
      flatbuffers::span<const std::uint16_t, HandTimes::kClasses>(times.round_trips));
}

HandReport value(const wire::HandReport& from, const wire::HandTimes* times) {
  HandReport report{
      .reasons = from.reasons() & kAllHandReasons,
      .has_account = (from.flags() & kFlagAccount) != 0,
      .balance = static_cast<double>(from.balance()),
      .round_trip = static_cast<double>(from.round_trip()),
      .hand_damping = static_cast<double>(from.hand_damping()),
      .late_ticks = from.flags() >> kLateTicksShift,
      .change = static_cast<std::uint8_t>((from.flags() >> kChangeShift) & ClientChange::kLast),
      .change_refused = (from.flags() & kFlagChangeRefused) != 0};
  if (times == nullptr) return report;
  report.times.emplace();
  for (flatbuffers::uoffset_t i = 0; i < HandTimes::kClasses; ++i) {
    report.times->wakeups[i] = times->wakeups()->Get(i);
    report.times->round_trips[i] = times->round_trips()->Get(i);
  }
  return report;
}

}  // namespace feltwire
