#pragma once
// The objects of a world at their present places, as its tools meet them.

#include <cstddef>
#include <vector>

#include "core/dynamics/neighbour_list.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// The velocity of a moving object, world frame.
struct ObjectVelocity {
  Vec3 linear = Vec3::Zero();   // [m/s] of the object's origin
  Vec3 angular = Vec3::Zero();  // [rad/s]
};

/// The objects as one of the tools meets them. They are at the same places for all tools, but a
/// mesh is triangles for a point and a grid for a body.
struct MovedView {
  const ToolView* view;
  std::vector<Object> objects;  // static ones first; moving ones at their present places
  NeighbourSearch reach;        // of those that move
};

/// All objects of a scene: the static ones, and the moving ones with pose and velocity. A moving
/// object has a number, its `part`, that begins at 0 behind the static objects.
class MovingObjects {
 public:
  /// All objects are at their starts, without velocity. The scene must outlive it. Precondition:
  /// the scene has a mechanism.
  explicit MovingObjects(const Scene& scene);

  std::size_t still() const { return still_; }               // number of static objects
  std::size_t moving() const { return velocities_.size(); }  // number of moving objects
  /// A view for each of Scene::views().
  const std::vector<MovedView>& views() const { return views_; }

  const Pose& pose(std::size_t part) const { return views_.front().objects[still_ + part].pose; }
  const ObjectVelocity& velocity(std::size_t part) const { return velocities_[part]; }
  /// [m/s] of the material point of an object (static or moving) that is at `point` [m, world].
  Vec3 velocity_at(std::size_t object, const Vec3& point) const noexcept;
  /// Whether the shape must know from where a tool comes, in the shape's own frame.
  bool follows_way(std::size_t part) const { return followed_[part].way; }
  /// The pose before the last place().
  const Pose& previous_pose(std::size_t part) const { return followed_[part].before; }

  void place(std::size_t part, const Pose& pose, const ObjectVelocity& velocity) noexcept;
  /// Ends a step: every moving object has been placed.
  void placed() noexcept;
  /// After a pose that may not have been finite. The caller must discard every NeighbourList.
  void begin_anew() noexcept;
  /// Takes the materials of another scene, which differs only in these and must outlive it.
  void adopt(const Scene& scene) noexcept;

 private:
  struct Followed {
    bool way = false;
    Pose before;
  };

  std::size_t still_;
  std::vector<ObjectVelocity> velocities_;
  std::vector<Followed> followed_;
  std::vector<MovedView> views_;  // never empty
};

}  // namespace feltwire
