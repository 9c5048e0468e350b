#include "client/servo/scene_change_gate.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {

double SceneChangeGate::energy(const Tick& tick, const PortAccount& account) noexcept {
  const double wanted = length(tick.command.elastic);
  if (!(wanted > 0.0)) {  // the contact ended, and its pressed energy is lost
    forget();
    return 0.0;
  }
  pressed_ = std::max(0.0, pressed_ - tick.held.elastic.dot(tick.displacement));
  if (!open_) return 0.0;
  since_ += tick.hold_time;
  if (since_ > kOpen) return 0.0;

  const double next = std::min(wanted, length(tick.held.elastic) + slew_ * tick.hold_time);
  const Command risen{.elastic = next * direction(tick.command.elastic)};
  const Command now{.elastic = tick.held.elastic};
  const double stored = account.need_of_any_hand(tick.held, tick.hold_time);
  const double spare = std::min(pressed_, tick.margin) - stored;
  const double needed = account.need_of_any_hand(risen, tick.hold_time) -
                        account.need_of_any_hand(now, tick.hold_time);
  return std::max(0.0, std::min(spare, needed));
}

void SceneChangeGate::given(const Vec3& rendered, const Vec3& commanded) noexcept {
  constexpr double kAll = 1.0 - 1e-9;
  if (length(rendered) >= kAll * length(commanded)) open_ = false;
}

}  // namespace feltwire
