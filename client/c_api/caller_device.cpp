#include "client/c_api/caller_device.hpp"

namespace feltwire {

DeviceReading CallerDevice::read(Nanoseconds now) noexcept {
  DeviceReading reading;
  // Before the values: a move that comes between is taken again at the next tick.
  const std::uint64_t count = moves_.count();
  Move move;
  if (!moves_.get(move)) {
    reading.withheld = Withheld::not_homed;
    return reading;
  }
  if (count != taken_) {
    taken_ = count;
    moved_at_ = now;
  } else if (now - moved_at_ > stale_after_) {
    reading.withheld = Withheld::not_moved;
  } else {
    reading.fresh = false;
  }
  reading.pose.position = {move.position[0], move.position[1], move.position[2]};
  reading.pose.orientation = Quaternion(move.orientation[0], move.orientation[1],
                                        move.orientation[2], move.orientation[3]);
  reading.buttons = move.buttons;
  reading.deadman = move.deadman;
  return reading;
}

}  // namespace feltwire
