#include "client/servo/remote_hand.hpp"

#include <algorithm>
#include <span>

#include "client/servo/rise_limit.hpp"
#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

Remote nothing_of(std::uint8_t seat) {
  Remote remote;
  remote.seat = seat;
  return remote;
}

}  // namespace

void RemoteHand::take(const Remote& remote) noexcept {
  remote_ = nothing_of(seat_);
  if (remote.seat != seat_) return;
  remote_ = remote;
  if (remote.state != LinkState::disabled) energy_.take(remote.energy);
}

void RemoteHand::lead_another(std::uint8_t seat) noexcept {
  seat_ = seat;
  forget();
  surface_offset_ = {};
  energy_.restart();
}

void RemoteHand::forget() noexcept {
  remote_ = nothing_of(seat_);
  local_.clear();
  walls_.clear();
  weight_ = share_ = 0.0;
}

double RemoteHand::step(const Vec3& hand, const Vec3& displacement, const Vec3& held,
                        double elapsed) noexcept {
  hand_work_ -= share_ * held.dot(displacement);
  const bool engaged = remote_.state == LinkState::engaged;
  const bool tied = engaged && (remote_.contact.surface != 0 || remote_.others.count > 0);
  const std::span walls(remote_.walls.data(),
                        engaged ? static_cast<std::size_t>(remote_.wall_count) : 0);
  const std::uint32_t known = surface_offset_.known_surface();
  surface_offset_.step(hand, displacement, tied ? remote_.contact : RemoteContact{}, elapsed,
                       {.holds = RobotWalls::reach(hand - surface_offset_.offset(), walls),
                        .meets = remote_.meets_surfaces},
                       tied ? remote_.others : OtherSurfaces{});
  walls_.step(hand, walls, surface_offset_, elapsed);
  // This hand may already be behind a newly known surface, because another hand touched the surface
  // first. So the force of the surface rises slowly.
  if (tied && surface_offset_.known_surface() > known && !remote_.meets_surfaces) weight_ = 0.0;
  const double rise = remote_.meets_surfaces ? 1.0 : elapsed / fade_;
  weight_ = tied ? std::min(1.0, weight_ + rise) : std::max(0.0, weight_ - elapsed / fade_);
  if (tied)
    show(hand);
  else if (weight_ == 0.0)
    local_.clear();
  return energy_.step(elapsed);
}

/// Builds the local model of the robot's contacts. Its surfaces are shifted by the offset between
/// hand and robot.
void RemoteHand::show(const Vec3& hand) noexcept {
  constexpr double kReach = 1.0;  // [m] radius around the hand in which the model is valid
  LocalModel model;
  const auto add = [&](const RemoteContact& surface) {
    SurfacePatch& patch = model.patches[static_cast<std::size_t>(model.count++)];
    patch.point = surface.point + surface_offset_.offset();
    patch.normal = surface.normal.normalized();
    patch.velocity = surface.velocity;
    patch.radius = kReach + (patch.point - hand).norm();
    patch.material.stiffness = surface.stiffness;
    patch.material.static_friction = patch.material.dynamic_friction = surface.friction;
    patch.object = static_cast<std::uint16_t>(surface.surface);
    patch.feature = surface.surface;
    model.reach = std::max(model.reach, patch.radius);
  };
  if (remote_.contact.surface != 0) add(remote_.contact);
  for (const RemoteContact& other : remote_.others.view()) add(other);
  model.center = hand;
  local_.take(model);
}

double RemoteHand::may_rise(double way, double elapsed) const noexcept {
  return rise(local_.model(), way, elapsed) + rise(walls_.model(), way, elapsed);
}

Command RemoteHand::touch(const Tool& tool, const Command& beside, double age,
                          double elapsed) noexcept {
  Command command;
  if (weight_ > 0.0) command = weight_ * local_.touch(tool, age, elapsed).command;
  const Vec3 push = walls_.push(tool, elapsed);
  const double here = length(command.force()), there = length(beside.force()) + length(push);
  share_ = here > 0.0 ? here / (here + there) : 0.0;
  const bool pushes = here > 0.0;
  if (pushing_ && !pushes && !remote_.contact.touching) energy_.begin_contact();
  pushing_ = pushes;
  command.elastic += push;
  return command;
}

}  // namespace feltwire
