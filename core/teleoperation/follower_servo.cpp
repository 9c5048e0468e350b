#include "core/teleoperation/follower_servo.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

void above_zero(double value, const char* name) {
  if (std::isfinite(value) && value > 0.0) return;
  throw std::invalid_argument(std::string("follower: ") + name + " is " + std::to_string(value) +
                              "; give a finite number above 0");
}

const FollowerSpec& checked(const FollowerSpec& spec) {
  above_zero(spec.servo_period, "the servo period");
  above_zero(spec.stiffness, "the stiffness of its controller");
  if (!(spec.wrench_noise >= 0.0) || !std::isfinite(spec.wrench_noise))
    throw std::invalid_argument(
        "follower: the noise of its wrench must be finite and not negative");
  return spec;
}
const FollowerOptions& checked(const FollowerOptions& options) {
  validate(options);
  return options;
}

/// Returns the contact thresholds. They are above the sensor's noise, and never below their
/// defaults.
ContactEstimatorConfig estimate_of(const FollowerSpec& spec) {
  ContactEstimatorConfig config{.first_stiffness = spec.stiffness};
  config.on = std::max(config.on, 4.0 * spec.wrench_noise);
  config.off = std::max(config.off, 2.0 * spec.wrench_noise);
  return config;
}

bool finite(const FollowerReading& r) {
  return r.pose.position.allFinite() && r.pose.orientation.coeffs().allFinite() &&
         r.pose.orientation.squaredNorm() > 0.0 && r.velocity.allFinite() &&
         r.angular_velocity.allFinite() && (!r.force || r.force->allFinite()) &&
         r.torque.allFinite() && r.commanded.position.allFinite() &&
         r.commanded.orientation.coeffs().allFinite() && std::isfinite(r.gripper) &&
         std::isfinite(r.gripper_force);
}

}  // namespace

void validate(const FollowerOptions& options) {
  above_zero(options.motion.speed, "the speed limit");
  above_zero(options.motion.acceleration, "the acceleration limit");
  above_zero(options.motion.jerk, "the jerk limit");
  above_zero(options.motion.turning, "the limit of turning");
  above_zero(options.gripper.speed, "the gripper's speed limit");
  above_zero(options.gripper.catch_up, "the gripper's speed limit while it catches up");
  above_zero(seconds(options.silence), "the time of silence");
  if (options.workspace.count > Workspace::kMostGiven)
    throw std::invalid_argument("follower: its workspace has " +
                                std::to_string(options.workspace.count) +
                                " walls; give 16 at most");
  if (options.workspace.body_count > Workspace::kMostBodiesGiven)
    throw std::invalid_argument("follower: its workspace has " +
                                std::to_string(options.workspace.body_count) +
                                " bodies to keep out of; give 8 at most");
  for (const KeepOutBody& body : options.workspace.keep_out())
    if (!body.valid(Workspace::kFarthest))
      throw std::invalid_argument(
          "follower: a body to keep out of needs finite numbers within 1000 m, half extents of 0 "
          "or more, a radius of 0.001 m or more, and a unit orientation");
  if (!has_room(options.workspace, 0.0))
    throw std::invalid_argument(
        "follower: its workspace leaves no place that is inside of all its walls and outside of "
        "all that it keeps out of; move them apart");
}

FollowerServo::FollowerServo(const FollowerSpec& spec, const FollowerOptions& options)
    : spec_(checked(spec)),
      options_(checked(options)),
      estimate_(estimate_of(spec)),
      energy_(spec.wrench_noise),
      limit_(options.workspace),
      motion_(options.motion),
      gripper_(options.gripper, spec.gripper_opening),
      limiter_({.stiffness = spec.stiffness,
                .speed = options.motion.speed,
                .leash = options.leash,
                .first_touch = options.first_touch,
                .unfelt = options.unfelt}) {}

void FollowerServo::sit(const Workspace& seat) noexcept {
  limit_ = WorkspaceLimit(joined(options_.workspace, seat));
  limit_.begin(wanted_.pose);
}

void FollowerServo::take(const RobotTarget& target, Nanoseconds now) noexcept {
  if (target.index <= target_.index) {
    ++statistics_.targets_stale;
    return;
  }
  ++statistics_.targets;
  statistics_.link_states.take(target.state, 0, now);
  target_ = target;
  heard_ = now;
}

void FollowerServo::reconnected() noexcept { target_ = {}; }

bool FollowerServo::may_follow(const FollowerReading& reading, Nanoseconds now) const noexcept {
  return target_.index > 0 && target_.state == LinkState::engaged &&
         now - heard_ <= options_.silence && reading.ok && !reading.stopped;
}

bool FollowerServo::jumped(const Vec3& tip, Nanoseconds now) const noexcept {
  const double time = std::max(seconds(now - last_), spec_.servo_period);
  return (tip - tip_).norm() > kJump * options_.motion.speed * time;
}

void FollowerServo::lose(const Vec3& tip, Nanoseconds now) noexcept {
  lost_ = (tip - wanted_.pose.position).norm() > options_.leash / spec_.stiffness;
  tip_ = tip;
  last_ = now;
  motion_.begin(wanted_.pose);
  limit_.begin(wanted_.pose);
}

/// Estimates the contact of the tool and the energy that it exchanges.
void FollowerServo::sense(const FollowerReading& reading, double elapsed) noexcept {
  const Vec3& tip = reading.pose.position;
  state_.pose = {tip, reading.pose.orientation.normalized()};
  state_.velocity = reading.velocity;
  state_.angular_velocity = reading.angular_velocity;
  state_.force = reading.force;
  state_.torque = reading.torque;
  state_.gripper = reading.gripper;
  state_.gripper_force = reading.gripper_force;
  if (reading.force) {
    const Vec3& force = *reading.force;
    statistics_.largest_force = std::max(statistics_.largest_force, force.norm());
    state_.contact = estimate_.step(
        {.position = tip,
         .velocity = reading.velocity,
         .force = force,
         .elapsed = elapsed,
         .prior = options_.surfaces ? options_.surfaces->nearest(tip, elapsed) : SurfacePrior{}});
    state_.others = estimate_.others();
    energy_.moved(force, tip - tip_, elapsed);
  } else {
    state_.contact = {};  // Without a force sensor, the contact is unknown, not zero.
    state_.others = {};
  }
  tip_ = tip;
  state_.energy = energy_.counters();
  const auto in_series = [&](RemoteContact& surface) {
    const double k = surface.stiffness;
    if (surface.surface != 0) surface.stiffness = k * spec_.stiffness / (k + spec_.stiffness);
  };
  in_series(state_.contact);
  std::ranges::for_each(state_.others.surfaces, in_series);
}

void FollowerServo::steer(bool follow, double elapsed) noexcept {
  const bool touching = state_.contact.touching;
  if (follow != following_) {
    // In contact, the motion starts at rest from the held target, because the contact limits may
    // have moved this target away from the motion. In free flight, the motion continues and brakes.
    if (touching) motion_.begin(wanted_.pose);
    if (follow) {
      gripper_.engage();
      limit_.begin(wanted_.pose);
    }
    ++(follow ? statistics_.engagements : statistics_.holds);
    following_ = follow;
  }
  if (follow) {
    // In contact, keep the number of the known surface. If a hand engages there again, the small
    // first-touch limit would otherwise shake the robot. Ignore a number that this robot has not
    // given yet, because it comes from another robot.
    const bool own = target_.known_surface <= estimate_.newest();
    if (target_.known_surface != 0 || !touching) known_ = own ? target_.known_surface : 0;
    hand_work_ = target_.hand_work;
    wanted_.gripper = gripper_.step(target_.gripper, elapsed);
  }
  // A moving robot needs a distance to brake, so apply the walls also after the limits of motion.
  const Pose& moved =
      follow ? motion_.follow(limit_.aim(target_.pose), elapsed) : motion_.stop(elapsed);
  const Pose& pose = limit_.keep(moved);
  // Otherwise the motion would continue inside the body and leave it at another place.
  if (limit_.workspace().body_count > 0) motion_.held_at(pose.position, elapsed);
  wanted_.pose.position = limiter_.step({.wanted = pose.position,
                                         .robot = tip_,
                                         .force = state_.force.value_or(Vec3::Zero()),
                                         .surface = touching ? state_.contact.surface : 0,
                                         .known = known_,
                                         .hand_work = hand_work_,
                                         .elapsed = elapsed});
  wanted_.pose.orientation = pose.orientation;
}

FollowerTarget FollowerServo::step(const FollowerReading& reading, Nanoseconds now) noexcept {
  ++statistics_.samples;
  ++state_.index;
  state_.time = now;
  state_.ok = reading.ok;
  state_.stopped = reading.stopped;
  const bool usable = reading.ok && finite(reading);
  const bool lost = usable && begun_ && (lost_ || jumped(reading.pose.position, now));
  if (lost) lose(reading.pose.position, now);
  if (lost || !usable) {
    ++statistics_.faults;
    state_.ok = false;
    following_ = false;
    return wanted_;
  }
  double elapsed = spec_.servo_period;
  if (!begun_) {
    begun_ = true;
    tip_ = reading.pose.position;
    wanted_ = {reading.commanded, reading.gripper};
    motion_.begin(reading.commanded);
    limit_.begin(reading.commanded);
    gripper_.begin(reading.gripper);
  } else if (now > last_) {
    // A very late sample must not cause a large step.
    elapsed = std::min(seconds(now - last_), 10.0 * spec_.servo_period);
  }
  last_ = now;
  sense(reading, elapsed);
  steer(may_follow(reading, now), elapsed);
  return wanted_;
}

const RobotState& FollowerServo::report(const FollowerTarget& held) noexcept {
  if (held.pose.position.allFinite() && held.pose.orientation.coeffs().allFinite() &&
      held.pose.orientation.squaredNorm() > 0.0)
    state_.commanded = {held.pose.position, held.pose.orientation.normalized()};
  return state_;
}

}  // namespace feltwire
