// The scene's command of a tick: the newest reply, and the local models in place of it where they
// are valid.

#include <algorithm>

#include "client/servo/servo.hpp"
#include "core/base/numeric.hpp"
#include "core/local_model/contact_budget.hpp"

namespace feltwire {

/// Asks the local model at the place that the method wants. `command` is the reply's at first; the
/// model replaces it as far as the model is valid. Returns true if the model alone gave the force.
bool Servo::follow_model(const BoundingStep& step, Nanoseconds now, Command& command) noexcept {
  const double age = seconds(now - model_time_);
  if (newest_.body_modelled) return count_modelled(follow_body(step, age, command));
  const Vec3 offset = law_.bounding.probe(step.displacement, step.rotation).offset;
  model_moved_ = step.displacement + offset - last_offset_;
  const Vec3& velocity = velocity_.update(model_moved_, step.hold_time);
  last_offset_ = offset;
  const Tool tool{sample_.pose.position + offset, velocity};
  WorkLimit work = contact_work();
  const LocalForce force = local_.touch(tool, age, step.hold_time, &work);
  count_work(work);
  const double w = force.weight;
  command.elastic = w * force.command.elastic + (1.0 - w) * command.elastic;
  command.frictional = w * force.command.frictional + (1.0 - w) * command.frictional;
  if (remote_) {
    const Command met = meet_robot(tool, command, now, step.hold_time);
    command.elastic += met.elastic;
    command.frictional += met.frictional;
  }
  environment_ = command;
  return count_modelled(w);
}

/// Limits the work of a tick's contact, so that no server makes a tick late. Above the limit the
/// model has no weight, and the reply's command is used.
WorkLimit Servo::contact_work() const noexcept {
  const bool whole = local_.has_whole() || local_body_.has_whole();
  return WorkLimit(whole && fetched_ != nullptr ? fetched_->most_work : plane_work(period_));
}

void Servo::count_work(const WorkLimit& work) noexcept {
  statistics_.most_work = std::max(statistics_.most_work, work.done());
  statistics_.contact_cut += work.cut() ? 1 : 0;
}

/// Returns true if a model of this weight alone gives the force.
bool Servo::count_modelled(double weight) noexcept {
  ++(weight >= 1.0  ? statistics_.modelled
     : weight > 0.0 ? statistics_.half_modelled
                    : statistics_.beyond_model);
  return weight >= 1.0;
}

/// follow_model() for a tool with a body. Returns the weight of the model.
double Servo::follow_body(const BoundingStep& step, double age, Command& command) noexcept {
  const Probe probe = law_.bounding.probe(step.displacement, step.rotation);
  model_moved_ = step.displacement + probe.offset - last_offset_;
  last_offset_ = probe.offset;
  const Pose asked = moved(sample_.pose, probe.offset, probe.rotation);
  WorkLimit work = contact_work();
  const BodyForce force = local_body_.touch(asked, age, step.hold_time, &work);
  count_work(work);
  const double w = force.weight;
  command.elastic = w * force.command.elastic + (1.0 - w) * command.elastic;
  command.frictional = w * force.command.frictional + (1.0 - w) * command.frictional;
  command.torque = w * force.command.torque + (1.0 - w) * command.torque;
  environment_ = command;
  return w;
}

Command Servo::rise_limited(const BoundingStep& step) noexcept {
  if (newest_.body_modelled)
    return rise_.apply(step.command, local_body_.model(), length(model_moved_),
                       length(step.rotation), step.hold_time, local_body_.inertia());
  return rise_.apply(step.command, local_.model(), length(model_moved_), step.hold_time,
                     remote_ ? remote_->may_rise(length(model_moved_), step.hold_time) : 0.0);
}

/// The hand leaves a robot only while it does not move it and feels nothing of it.
void Servo::choose_robot(const DeviceReading& reading) noexcept {
  const bool pressed = reading.ok && options_.seat_button > 0 &&
                       (reading.buttons >> (options_.seat_button - 1) & 1u) != 0;
  if (pressed && !seat_pressed_ && !deadman_ && options_.seats.size() > 1)
    wanted_seat_ = static_cast<std::uint8_t>((wanted_seat_ + 1u) % options_.seats.size());
  seat_pressed_ = pressed;
  if (wanted_seat_ != remote_->seat() && !deadman_ && !remote_->pushes())
    remote_->lead_another(wanted_seat_);
}

/// The force of the objects that the robot touches, in addition to the scene's.
Command Servo::meet_robot(const Tool& tool, const Command& scene, Nanoseconds now,
                          double elapsed) noexcept {
  return remote_->touch(tool, scene, seconds(now - remote_time_), elapsed);
}

/// Computes the scene's command for this tick, from the newest reply and the local model.
Command Servo::environment(BoundingStep& step, Nanoseconds now) noexcept {
  Command command = reconstructed(now);
  if (law_.parameters.local_model) step.local = follow_model(step, now, command);
  statistics_.hand_overs += step.local == near_ ? 0 : 1;
  near_ = step.local;
  step.normals = &newest_.normals;
  return command;
}

}  // namespace feltwire
