#pragma once
// The hands, robots and moving objects of a scene, for observers and viewers.

#include <cstddef>

#include "protocol/wire/scene_view.hpp"
#include "server/picture/picture.hpp"
#include "server/scene/robot_seats.hpp"
#include "server/scene/served_scene.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/session_table.hpp"
#include "server/scene/world_clock.hpp"

namespace feltwire {

class ObserverViews {
 public:
  /// The other stages must outlive this.
  ObserverViews(const ServedScene& served, const SessionTable& table, const RobotSeats& seats,
                const WorldClock& clock)
      : served_(served), table_(table), seats_(seats), clock_(clock) {}

  /// The next part of an observer's view, of no more than `room` [bytes]. Valid until the next
  /// call. Never allocates.
  const SceneView& next(SessionSlot& observer, std::size_t room, Nanoseconds now) noexcept;

  /// The places of all hands, robots and moving objects, for viewers. May allocate; throws only
  /// std::bad_alloc.
  void draw(Picture& picture, Nanoseconds now) const;

 private:
  PictureHand picture_of(const SessionSlot& slot, Nanoseconds now) const noexcept;
  void add_figures(Nanoseconds now) noexcept;

  const ServedScene& served_;
  const SessionTable& table_;
  const RobotSeats& seats_;
  const WorldClock& clock_;
  SceneView view_;  // the newest
};

}  // namespace feltwire
