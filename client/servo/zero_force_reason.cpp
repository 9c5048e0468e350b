#include "client/servo/zero_force_reason.hpp"

#include <numeric>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

struct ReasonText {
  std::string_view name, text;
};

constexpr std::array<ReasonText, kZeroForceReasons> kWords = {{
    {"felt", ""},
    {"observer", "an observer is given none"},
    {"device_ended", "the recording is over"},
    {"ending", "the run ends"},
    {"device_fault", "the device gives no position"},
    {"no_reply", "the server has not answered yet"},
    {"reconnecting", "the session has just been found again"},
    {"silent", "no fresh answer from the server"},
    {"recovering", "the server has put back what moves"},
    {"server_bound", "the server's energy bound lets none through"},
    {"touches_nothing", "the hand touches nothing"},
    {"too_little", "the scene asks for less than 0.005 N"},
    {"not_actuated", "the device cannot give what the scene asks for"},
    {"waiting", "waits: move the hand out of contact first"},
    {"refused", "the command or the movement was beyond every limit"},
    {"bound", "the energy bound lets none through"},
    {"velocity_limit", "the hand is faster than --velocity-limit allows"},
    {"ramp", "--ramp-up has just begun"},
    {"slew", "--slew lets it rise slowly"},
    {"force_limit", "--max-force allows less than 0.005 N"},
    {"account", "the device has not burned enough energy for it"},
    {"not_held", "the device does not hold what it is given"},
    {"law_change", "an admin has just given the session another law"},
    {"clutched", "the clutch is held: the hand moves without the tool"},
    {"not_homed", "the device must be homed first"},
    {"in_inkwell", "the stylus is in its inkwell"},
    {"starting", "hold the hand still to start"},
    {"emergency", "EMERGENCY STOP; press r to start again"},
    {"jumped", "the device's position jumped farther than a hand can move"},
    {"overdrawn", "FAULT: the hand got more energy than the device had burned; start anew"},
    {"not_moved", "the program that moves the hand has given no new position for too long"},
}};

ZeroForceReason reason_of(Withheld withheld) {
  switch (withheld) {
    case Withheld::not_homed:
      return ZeroForceReason::not_homed;
    case Withheld::in_inkwell:
      return ZeroForceReason::in_inkwell;
    case Withheld::not_moved:
      return ZeroForceReason::not_moved;
    case Withheld::starting:
      return ZeroForceReason::starting;
    case Withheld::emergency:
      return ZeroForceReason::emergency;
    case Withheld::nothing:
      break;
  }
  return ZeroForceReason::device_fault;
}
/// Returns whether the wait for a small force leaves less than a tenth of the possible force.
bool held_back(const ForceTrail& t) {
  constexpr double kShare = 0.1;
  const Command &actuated = t.command.actuated, &held = t.command.held;
  return t.safety.waits && is_felt(actuated) &&
         length(held.force()) <= kShare * length(actuated.force()) &&
         length(held.torque) <= kShare * length(actuated.torque);
}
bool any(const Command& c) { return length(c.force()) > 0.0 || length(c.torque) > 0.0; }

}  // namespace

bool is_felt(const Command& c) noexcept {
  return length(c.force()) >= kFeltForce || length(c.torque) >= kFeltTorque;
}

std::string_view name(ZeroForceReason reason) {
  return kWords[static_cast<std::size_t>(reason)].name;
}
std::string_view text(ZeroForceReason reason) {
  return kWords[static_cast<std::size_t>(reason)].text;
}

ZeroForceReason zero_force_reason(const ForceTrail& t) noexcept {
  const CommandTrail& command = t.command;
  if (is_felt(command.held) && !held_back(t)) return ZeroForceReason::felt;
  if (t.observer) return ZeroForceReason::observer;
  if (t.device.ended) return ZeroForceReason::device_ended;
  if (t.overdrawn) return ZeroForceReason::overdrawn;
  if (t.released) return ZeroForceReason::ending;
  if (t.device.clutched) return ZeroForceReason::clutched;
  if (t.device.jumped) return ZeroForceReason::jumped;
  if (!t.device.usable) return reason_of(t.device.withheld);
  if (!t.reply.answered) return ZeroForceReason::no_reply;
  if (t.letting_go)
    return t.law_change ? ZeroForceReason::law_change : ZeroForceReason::reconnecting;
  if (t.reply.silent) return ZeroForceReason::silent;
  if (!is_felt(command.asked)) {
    if (t.reply.recovering) return ZeroForceReason::recovering;
    if (t.reply.server_bound) return ZeroForceReason::server_bound;
    return any(command.asked) ? ZeroForceReason::too_little : ZeroForceReason::touches_nothing;
  }
  if (!is_felt(command.actuated)) return ZeroForceReason::not_actuated;
  // Test `waits` before `bounded`. During the wait the force bound may also give no force,
  // but the wait is the reason.
  if (t.safety.waits) return ZeroForceReason::waiting;
  if (!is_felt(command.faded)) return ZeroForceReason::silent;
  if (!is_felt(command.bounded))
    return t.refused ? ZeroForceReason::refused : ZeroForceReason::bound;
  if (!is_felt(command.safe)) {
    if (t.refused) return ZeroForceReason::refused;
    if (t.safety.too_fast) return ZeroForceReason::velocity_limit;
    if (t.safety.ramped) return ZeroForceReason::ramp;
    return t.safety.slewed ? ZeroForceReason::slew : ZeroForceReason::force_limit;
  }
  return is_felt(command.paid) ? ZeroForceReason::not_held : ZeroForceReason::account;
}

ZeroForceReason prevailing(const std::array<std::uint64_t, kZeroForceReasons>& ticks) noexcept {
  // These reasons are normal: the scene gave no force, or the session started or ended.
  constexpr std::array kNothingToGive = {
      ZeroForceReason::felt,     ZeroForceReason::ending,          ZeroForceReason::device_ended,
      ZeroForceReason::no_reply, ZeroForceReason::touches_nothing, ZeroForceReason::too_little,
      ZeroForceReason::clutched};
  constexpr std::uint64_t kShare = 100;
  const std::uint64_t all = std::accumulate(ticks.begin(), ticks.end(), std::uint64_t{0});
  auto rest = ticks;
  for (const ZeroForceReason reason : kNothingToGive) rest[static_cast<std::size_t>(reason)] = 0;
  const auto most = [](const auto& counts) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < counts.size(); ++i)
      if (counts[i] > counts[best]) best = i;
    return best;
  };
  const std::size_t kept_away = most(rest);
  if (rest[kept_away] > 0 && rest[kept_away] * kShare >= all)
    return static_cast<ZeroForceReason>(kept_away);
  return static_cast<ZeroForceReason>(most(ticks));
}

}  // namespace feltwire
