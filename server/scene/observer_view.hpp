#pragma once
// The view of a scene for an observer: a part with each reply, in turns.

#include <span>

#include "core/dynamics/world.hpp"
#include "protocol/wire/scene_view.hpp"
#include "server/scene/session.hpp"

namespace feltwire {

/// A session that acts in a scene, and its number for observers.
struct ActingHand {
  std::uint32_t number = 0;  // from 1 in the order they joined, never used again
  const Session* session = nullptr;
};

/// The progress of one observer's view: first the hands, then the moving objects, then again from
/// the beginning.
class ObserverView {
 public:
  /// The next part, of no more than `room` [bytes]: at most one list of hands, from the end of the
  /// last part, and one of bodies. `hands` by rising number; `world` is null if nothing moves. A
  /// hand takes `hand_size` [bytes]. A hand that has sent nothing yet is left out. Never allocates.
  void show(std::span<const ActingHand> hands, const World* world, std::size_t room,
            SceneView& view, std::size_t hand_size = SceneView::kHandSize) noexcept;

 private:
  std::size_t show_hands(std::span<const ActingHand> hands, std::size_t room, SceneView& view,
                         std::size_t hand_size) noexcept;
  void show_bodies(const World* world, std::size_t room, SceneView& view) noexcept;

  std::uint32_t next_hand_ = 0;
  std::uint16_t next_body_ = 0;
  bool hands_shown_ = false;  // all of this round
};

}  // namespace feltwire
