#include "client/servo/virtual_environment.hpp"

#include <algorithm>
#include <stdexcept>

#include "client/servo/servo_law.hpp"
#include "core/base/numeric.hpp"
#include "core/local_model/contact_budget.hpp"

namespace feltwire {
namespace {

/// Returns the robot that the hand leads, or nothing. The client renders the robot's contact like a
/// local model.
std::optional<RobotLead> robot_of(const ServoOptions& options, const SessionParameters& p) {
  if (!options.leads) return std::nullopt;
  if (!p.local_model)
    throw std::invalid_argument(
        "a hand that leads a robot needs the local model: ask for local_model");
  return RobotLead(options, 0.5 * p.hold_time);
}

void count_work(const WorkLimit& work, LocalModelCounts& counts) noexcept {
  counts.most_work = std::max(counts.most_work, work.done());
  counts.contact_cut += work.cut() ? 1 : 0;
}

}  // namespace

VirtualEnvironment::VirtualEnvironment(const DeviceSpec& spec, const SessionParameters& parameters,
                                       const ServoOptions& options)
    : period_(parameters.servo_period),
      velocity_(parameters.velocity_cutoff),
      rise_(largest_slew(spec.max_force, parameters), largest_slew(spec.max_torque, parameters)),
      robot_(robot_of(options, parameters)) {}

void VirtualEnvironment::use(const FetchedScene* fetched) noexcept {
  fetched_ = fetched;
  local_.use(fetched != nullptr ? fetched->surfaces.get() : nullptr);
  local_body_.use(fetched != nullptr ? fetched->body.get() : nullptr);
}

void VirtualEnvironment::take(const ReplyIntake& replies, std::uint64_t samples, double hold_time,
                              LocalModelCounts& counts) noexcept {
  const Reply& reply = replies.newest();
  const bool body = reply.body_modelled;
  if (!reply.modelled) local_.clear();
  if (!body) local_body_.clear();
  if (!reply.modelled && !body) return;
  if (reply.modelled) local_.take(reply.model, replies.original() ? &reply.command : nullptr);
  if (body) local_body_.take(reply.body, samples - reply.sample_index + 1);
  ++counts.received;
  counts.whole += local_.has_whole() || (body && local_body_.has_whole()) ? 1 : 0;
  counts.patches += reply.modelled ? reply.model.view().size() : reply.body.view().size();
  // Moving objects have moved since the server computed the reply. The clock estimate gives the
  // delay of the reply, limited to the hold time of a command.
  const double since = std::clamp(replies.server_clock().delay_down(), 0.0, hold_time);
  model_time_ = replies.arrival() - from_seconds(since);
  if (robot_) robot_->take(reply, model_time_, replies.arrival(), hold_time);
}

Command VirtualEnvironment::command(BoundingStep& step, const Bounding& bounding, const Pose& pose,
                                    const ReplyIntake& replies, const SessionParameters& parameters,
                                    Nanoseconds now, LocalModelCounts& counts) noexcept {
  Command command = replies.command(now, parameters.keep_alive);
  if (parameters.local_model) {
    const Probe probe = bounding.probe(step.displacement, step.rotation);
    model_moved_ = step.displacement + probe.offset - last_offset_;
    last_offset_ = probe.offset;
    const double weight = replies.newest().body_modelled
                              ? follow_body(step, probe, pose, now, command, counts)
                              : follow_point(step, probe, pose, now, command, counts);
    command_ = command;
    ++(weight >= 1.0 ? counts.from_model : weight > 0.0 ? counts.from_both : counts.beyond_reach);
    step.local = weight >= 1.0;
  }
  counts.hand_overs += step.local == near_ ? 0 : 1;
  near_ = step.local;
  step.normals = &replies.newest().normals;
  return command;
}

/// Evaluates the local model at the position `probe` that the bounding method requests. `command`
/// has the force of the reply, and the function blends it with the force of the model. Returns the
/// weight of the model, 0 to 1.
double VirtualEnvironment::follow_point(const BoundingStep& step, const Probe& probe,
                                        const Pose& pose, Nanoseconds now, Command& command,
                                        LocalModelCounts& counts) noexcept {
  const Vec3& velocity = velocity_.update(model_moved_, step.hold_time);
  const Tool tool{pose.position + probe.offset, velocity};
  WorkLimit work = contact_work();
  const LocalForce force = local_.touch(tool, seconds(now - model_time_), step.hold_time, &work);
  count_work(work, counts);
  const double w = force.weight;
  command.elastic = w * force.command.elastic + (1.0 - w) * command.elastic;
  command.frictional = w * force.command.frictional + (1.0 - w) * command.frictional;
  if (robot_) {
    const Command met = robot_->touch(tool, command, now, step.hold_time);
    command.elastic += met.elastic;
    command.frictional += met.frictional;
  }
  return w;
}

/// Does the same as follow_point() for a tool with a body.
double VirtualEnvironment::follow_body(const BoundingStep& step, const Probe& probe,
                                       const Pose& pose, Nanoseconds now, Command& command,
                                       LocalModelCounts& counts) noexcept {
  const Pose asked = moved(pose, probe.offset, probe.rotation);
  WorkLimit work = contact_work();
  const BodyForce force =
      local_body_.touch(asked, seconds(now - model_time_), step.hold_time, &work);
  count_work(work, counts);
  const double w = force.weight;
  command.elastic = w * force.command.elastic + (1.0 - w) * command.elastic;
  command.frictional = w * force.command.frictional + (1.0 - w) * command.frictional;
  command.torque = w * force.command.torque + (1.0 - w) * command.torque;
  return w;
}

/// Returns the limit of the contact work of a tick, so that a large model cannot make the tick
/// late. Above the limit the weight of the model is zero, and the reply's command applies.
WorkLimit VirtualEnvironment::contact_work() const noexcept {
  const bool whole = local_.has_whole() || local_body_.has_whole();
  return WorkLimit(whole && fetched_ != nullptr ? fetched_->most_work : plane_work(period_));
}

Command VirtualEnvironment::rise_limited(const BoundingStep& step,
                                         const ReplyIntake& replies) noexcept {
  const double way = length(model_moved_);
  if (replies.newest().body_modelled)
    return rise_.apply(step.command, local_body_.model(), way, length(step.rotation),
                       step.hold_time, local_body_.inertia());
  return rise_.apply(step.command, local_.model(), way, step.hold_time,
                     robot_ ? robot_->hand().may_rise(way, step.hold_time) : 0.0);
}

void VirtualEnvironment::forget() noexcept {
  local_.clear();
  local_body_.clear();
  if (robot_) robot_->hand().forget();
  last_offset_.setZero();
}

}  // namespace feltwire
