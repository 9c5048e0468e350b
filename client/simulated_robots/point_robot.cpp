#include "client/simulated_robots/point_robot.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace feltwire {
namespace {

constexpr double kLongestStep = 50e-6;   // [s] longest integration step
constexpr double kReferenceRate = 20.0;  // [Hz] low-pass cutoff for the target's velocity
constexpr double kLongestGap = 0.1;      // [s] longest time to integrate in one call

void check(const PointRobotOptions& o) {
  const auto usable = [](double v) { return std::isfinite(v) && v >= 0.0; };
  if (usable(o.mass) && o.mass > 0.0 && usable(o.stiffness) && o.stiffness > 0.0 &&
      usable(o.damping) && usable(o.own_damping) && usable(o.wrench_noise) &&
      usable(o.servo_period) && o.servo_period > 0.0)
    return;
  throw std::invalid_argument(
      "the robot's mass, stiffness and servo period must be above zero, its dampings and the noise "
      "of its wrench not negative, and all of them finite");
}

}  // namespace

PointRobot::PointRobot(std::shared_ptr<const Scene> scene, const Vec3& position,
                       const PointRobotOptions& options)
    : scene_(std::move(scene)),
      options_((check(options), options)),
      spec_{.name = "point",
            .servo_period = options.servo_period,
            .stiffness = options.stiffness,
            .damping = options.damping,
            .own_damping = options.own_damping,
            .mass = options.mass,
            .senses_wrench = true,
            .wrench_noise = std::sqrt(3.0) * options.wrench_noise,
            .gripper_opening = 0.0},
      memory_(scene_->views().front().memory()),
      random_(options.seed),
      position_(position),
      target_{{position, Quaternion::Identity()}, 0.0},
      target_before_(position) {}

FollowerReading PointRobot::read(Nanoseconds now) noexcept {
  if (started_) integrate(std::clamp(seconds(now - last_), 0.0, kLongestGap));
  started_ = true;
  last_ = now;
  std::uniform_real_distribution<double> noise(-options_.wrench_noise, options_.wrench_noise);
  FollowerReading reading;
  reading.pose = {position_, target_.pose.orientation};
  reading.velocity = velocity_;
  Vec3 error;
  for (double& e : error) e = options_.wrench_noise > 0.0 ? noise(random_) : 0.0;
  reading.force = force_ + error;
  reading.commanded = target_.pose;
  reading.stopped = stopped_;
  return reading;
}

FollowerTarget PointRobot::write(const FollowerTarget& target) noexcept {
  const bool usable =
      target.pose.position.allFinite() && target.pose.orientation.coeffs().allFinite();
  if (!stopped_ && !held_.load() && usable) target_ = target;
  return target_;
}

void PointRobot::integrate(double time) noexcept {
  if (!(time > 0.0)) return;
  const Vec3 speed = (target_.pose.position - target_before_) / time;
  target_before_ = target_.pose.position;
  const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * kReferenceRate * time);
  target_velocity_ += share * (speed - target_velocity_);
  const int steps = std::max(1, static_cast<int>(std::ceil(time / kLongestStep)));
  const double h = time / steps;
  const ToolView& view = scene_->views().front();
  for (int i = 0; i < steps; ++i) {
    force_ = view.touch({position_, velocity_}, memory_).force();
    const Vec3 pull = options_.stiffness * (target_.pose.position - position_) +
                      options_.damping * (target_velocity_ - velocity_) -
                      options_.own_damping * velocity_ + force_;
    velocity_ += h / options_.mass * pull;
    position_ += h * velocity_;
  }
}

}  // namespace feltwire
