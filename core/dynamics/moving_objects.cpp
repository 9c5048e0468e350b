#include "core/dynamics/moving_objects.hpp"

#include <span>

#include "core/scene/mechanism.hpp"

namespace feltwire {

MovingObjects::MovingObjects(const Scene& scene)
    : still_(scene.mechanism()->still()),
      velocities_(scene.mechanism()->parts().size()),
      followed_(velocities_.size()) {
  for (const ToolView& view : scene.views()) {
    const std::span<const Object> moving(view.objects().data() + still_, velocities_.size());
    views_.push_back({&view, view.objects(), NeighbourSearch(moving, view.tool().radius)});
    for (std::size_t i = 0; i < moving.size(); ++i)
      followed_[i].way |= feltwire::follows_way(moving[i].shape, moving[i].felt_from);
  }
}

Vec3 MovingObjects::velocity_at(std::size_t object, const Vec3& point) const noexcept {
  const std::vector<Object>& objects = views_.front().objects;
  if (object < still_ || object >= objects.size()) return Vec3::Zero();
  const ObjectVelocity& velocity = velocities_[object - still_];
  return velocity.linear + velocity.angular.cross(point - objects[object].pose.position);
}

void MovingObjects::place(std::size_t part, const Pose& pose,
                          const ObjectVelocity& velocity) noexcept {
  followed_[part].before = this->pose(part);
  for (MovedView& moved : views_) {
    moved.objects[still_ + part].pose = pose;
    moved.reach.place(part, pose);
  }
  velocities_[part] = velocity;
}

void MovingObjects::placed() noexcept {
  for (MovedView& moved : views_) moved.reach.placed();
}

void MovingObjects::begin_anew() noexcept {
  for (MovedView& moved : views_) moved.reach.begin_anew();
}

void MovingObjects::adopt(const Scene& scene) noexcept {
  for (std::size_t held = 0; held < views_.size(); ++held) {
    MovedView& moved = views_[held];
    moved.view = &scene.views()[held];
    for (std::size_t i = 0; i < moved.objects.size(); ++i)
      moved.objects[i].material = moved.view->objects()[i].material;
  }
}

}  // namespace feltwire
