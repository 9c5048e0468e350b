#include "server/scene/world_arm.hpp"

namespace feltwire {
namespace {

FollowerOptions options_of(const RemoteSeat& seat) {
  FollowerOptions options;
  options.motion.speed = seat.speed;
  options.workspace = seat.workspace;
  return options;
}

}  // namespace

WorldArm::WorldArm(const RemoteSeat& seat, World& world)
    : arm_(*seat.arm, world.tick(), "the scene's mjcf", world.model(), world.state()),
      servo_(arm_.spec(), options_of(seat)) {}

void WorldArm::drive(World& world, TeleopLink& link, Nanoseconds now) noexcept {
  if (link.target_due(now)) servo_.take(link.target(now), now);
  const FollowerTarget wanted = servo_.step(arm_.reading(), now);
  link.follow(servo_.report(arm_.aim(wanted, world.state())), now);
  arm_.spread(1);
  arm_.drive(world.state());
}

void WorldArm::sense(World& world) noexcept {
  const WorldCounters& counters = world.counters();
  if (counters.resets != resets_) {
    resets_ = counters.resets;
    arm_.put_back(world.state());
  } else {
    arm_.judge(arm_.weigh(world.state()), world.state());
  }
  arm_.read(world.state(), counters.steps);
  if (arm_.reading().stopped) [[unlikely]]
    end_stop(world.tick());
}

void WorldArm::end_stop(double elapsed) noexcept {
  calm_ = arm_.is_calm() ? calm_ + elapsed : 0.0;
  if (calm_ < kStopped) return;
  calm_ = 0.0;
  arm_.resume();
}

}  // namespace feltwire
