#include "client/servo/robot_lead.hpp"

#include <algorithm>

namespace feltwire {

/// Reads the enabling switch and the seat button. The hand may select another robot only while it
/// neither moves its present robot nor feels the robot's force.
void RobotLead::take(const DeviceReading& reading, bool free,
                     const ServoOptions& options) noexcept {
  deadman_ = reading.ok && reading.deadman && free;
  if (reading.ok) gripper_ = reading.gripper;
  const bool pressed = reading.ok && options.seat_button > 0 &&
                       (reading.buttons >> (options.seat_button - 1) & 1u) != 0;
  if (pressed && !seat_pressed_ && !deadman_ && options.seats.size() > 1)
    wanted_seat_ = static_cast<std::uint8_t>((wanted_seat_ + 1u) % options.seats.size());
  seat_pressed_ = pressed;
  if (wanted_seat_ != hand_.seat() && !deadman_ && !hand_.pushes())
    hand_.lead_another(wanted_seat_);
}

void RobotLead::take(const Reply& reply, Nanoseconds state, Nanoseconds arrival,
                     double hold_time) noexcept {
  hand_.take(reply.remote.value_or(Remote{}));
  if (reply.remote) states_.take(reply.remote->state, reply.remote->seat, arrival);
  state_time_ = state - from_seconds(std::min(hand_.remote().age, hold_time));
}

}  // namespace feltwire
