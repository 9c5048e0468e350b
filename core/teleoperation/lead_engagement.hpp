#pragma once
// The engagement of a hand that leads a robot: when it may move the robot.

#include <cstdint>
#include <string_view>

namespace feltwire {

/// The state between a hand and a robot. The numbers are the wire's. Only in `engaged` does the
/// robot's target move.
enum class LinkState : std::uint8_t {
  disabled,  // the hand or the robot is missing, or the hand has not shown a released switch yet
  ready,     // press the switch to engage
  engaged,   // the target follows the hand
  clutched,  // the switch was released; the hand may move to another place
  hold,      // the hand is silent, or a limit was passed: release the switch, then press
  fault,     // the robot is silent, stopped or faulty: wait for it, release the switch, then press
  aligning   // the hand is turned away from the robot: turn it with a released switch
};
inline constexpr LinkState kLastLinkState = LinkState::aligning;
std::string_view name(LinkState state);

/// The facts that decide the state, at one moment.
struct LinkInputs {
  bool seated = false;  // hand and robot have their seats
  bool robot_well =
      false;  // its newest state is recent, says that the robot is well, and there is no stop
  bool hand_silent = false;   // no sample of the hand arrived for the deadman's time
  bool refused = false;       // the hand jumped, or the robot's wrench passed its limit
  bool deadman = false;       // the switch in the hand's newest sample
  bool wrench_above = false;  // the robot's wrench is above its limit
  bool aligned = true;        // false: the hand is turned away from the robot (Alignment)
};

/// The states. The switch (deadman) is read from the newest sample and never remembered as pressed.
/// It arms in two steps: after `disabled`, `hold` and `fault` it must be seen released before it
/// engages. So neither a switch that is taped down nor a hand that comes back moves a robot. A
/// wrench above its limit causes `hold`. If the hand engages while the wrench is above the limit,
/// it can lead the robot out; then the next rise above the limit causes `hold`. A hand that is not
/// aligned does not engage: a switch that it presses must be seen released again. While the hand is
/// engaged it may turn as it likes.
///
/// A pure function of its inputs in their order. It is no safety-rated function.
class LeadEngagement {
 public:
  LinkState step(const LinkInputs& in) noexcept {
    const LinkState before = state_;
    state_ = next(in);
    if (state_ == LinkState::engaged && before != LinkState::engaged) forgiven_ = in.wrench_above;
    if (!in.wrench_above) forgiven_ = false;
    return state_;
  }
  LinkState state() const noexcept { return state_; }

 private:
  LinkState next(const LinkInputs& in) noexcept {
    const bool linked = state_ == LinkState::engaged || state_ == LinkState::clutched;
    const bool wrench = state_ == LinkState::engaged && in.wrench_above && !forgiven_;
    if (!in.seated) return drop(LinkState::disabled);
    if (!in.robot_well) return drop(LinkState::fault);
    if (in.hand_silent) return drop(state_ == LinkState::disabled ? state_ : LinkState::hold);
    if (linked && (in.refused || wrench)) return drop(LinkState::hold);
    if (!in.deadman) {
      armed_ = true;
      if (!in.aligned) return LinkState::aligning;
      return linked ? LinkState::clutched : LinkState::ready;
    }
    if (!armed_) return state_;
    if (state_ == LinkState::engaged || in.aligned) return LinkState::engaged;
    return drop(LinkState::aligning);
  }
  LinkState drop(LinkState to) noexcept {
    armed_ = false;
    return to;
  }

  LinkState state_ = LinkState::disabled;
  bool armed_ = false;  // the switch was seen released
  bool forgiven_ =
      false;  // the wrench was above its limit when the hand engaged, and has been so ever since
};

}  // namespace feltwire
