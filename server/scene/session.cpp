#include "server/scene/session.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/body_points.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/local_model_extraction/prefetched_tool_data.hpp"
#include "core/tool/body_tool.hpp"
#include "server/scene/client_time.hpp"
#include "server/scene/shortened_model.hpp"

namespace feltwire {
namespace {

const control::JoinRequest& checked(const control::JoinRequest& request) {
  validate(request.device);
  validate(request.parameters);
  return request;
}

/// Checks that a force bound made for the parameters `a` is valid for `b` too: they differ only in
/// parameters that the bound does not use.
bool same_bound(SessionParameters a, const SessionParameters& b) {
  a.velocity_cutoff = b.velocity_cutoff;
  a.hold_time = b.hold_time;
  // The parameters below only set the content and the rate of messages.
  a.redundancy = b.redundancy;
  a.packet_interval = b.packet_interval;
  a.batch = b.batch;
  a.position_deadband = b.position_deadband;
  a.force_deadband = b.force_deadband;
  a.predictor = b.predictor;
  a.keep_alive = b.keep_alive;
  a.local_model = b.local_model;
  return a == b;
}

/// Checks that the client uses a bounding method that shapes the force (`shapes`). Such a method
/// prevents oscillation at each touched surface, and needs the normals of these surfaces.
bool shapes_at_client(const SessionParameters& parameters) {
  return parameters.side == BoundingSide::client && bounding_method(parameters.mode).shapes;
}

/// Returns the ratio |rendered| / |commanded| of the forces, or 1 if the commanded force is zero.
double force_ratio(const Command& rendered, const Command& commanded) {
  const double wanted = length(commanded.force());
  return wanted > 0.0 ? length(rendered.force()) / wanted : 1.0;
}

}  // namespace

/// The movement of the device from the session's newest sample to the next sample.
struct Session::Movement {
  Vec3 displacement = Vec3::Zero();  // [m]
  Vec3 rotation = Vec3::Zero();      // [rad] rotation vector
  double nominal_time = 0.0;         // [s] servo periods between the two samples
  double elapsed = 0.0;              // [s] time by the client's clock
};

Session::Session(const control::JoinRequest& request, const ToolView& view, World* world)
    : client_(checked(request).client),
      device_(request.device),
      parameters_(request.parameters),
      observes_(!feels(request.role)),
      sends_normals_(shapes_at_client(parameters_)),
      place_(view, world, limits()),
      bound_{.bounding = Bounding(bounding_config(parameters_, device_))},
      velocity_(parameters_.velocity_cutoff),
      observer_(device_.damping, device_.rotational_damping, parameters_.servo_period),
      deadband_(parameters_) {}

BatchResult Session::take(const SampleBatch& batch, Nanoseconds now) noexcept {
  BatchResult taken;
  taken.drop = check(batch);
  if (taken.drop != DropReason::none) return taken;
  if (batch.samples[0].index <= newest_.sample.index) {
    ++counters_.duplicates;
    taken.drop = DropReason::stale;
    return taken;
  }

  count_gap(batch, taken.reply);
  // A batch begins with its newest sample. Step from the oldest to the newest, and skip samples
  // that are already processed.
  for (int i = batch.count - 1; i >= 0; --i) {
    const Sample& sample = batch.samples[static_cast<std::size_t>(i)];
    if (sample.index > newest_.sample.index) step(sample, batch.rotation, taken.reply);
  }
  if (batch.report) hear(*batch.report);
  Reply& reply = taken.reply;
  newest_.outcome.bounded = reply.bound.active;
  newest_.outcome.saturated = reply.bound.saturated;
  newest_.outcome.refused = reply.bound.refused;
  newest_.outcome.gap = reply.gap;
  reply.sample_index = newest_.sample.index;
  reply.client_time = newest_.sample.client_time;
  reply.server_times.received = reply.server_times.sent = now;
  reply.rotation = device_.rotation_actuated > 0;
  const bool modelled = parameters_.local_model && !observes_,
             has_body = place_.view->tool().body != nullptr && touches();
  reply.modelled = modelled && !has_body;
  if (reply.modelled) reply.model = model();
  if (modelled && has_body) reply.body = body_model();
  reply.body_modelled = reply.body.reach > 0.0;  // the reach is 0 if the model cannot be sent
  reply.model.scene = reply.body.scene = scenes_;
  if (sends_normals_ && !reply.command.elastic.isZero(0.0))
    reply.normals =
        pushing_normals(reply.modelled ? reply.model : model(), newest_.sample.pose.position);
  reply.delivered = delivered();
  reply.reloads = reloads_;
  reply.recovering = place_.world != nullptr && place_.world->recovering();
  // A hand that leads a robot always gets its reply, which has the robot's contacts.
  taken.withheld = deadband_.withhold(reply) && !batch.lead;
  ++(taken.withheld ? counters_.withheld : counters_.replies);
  reply.withheld = counters_.withheld;
  return taken;
}

/// Takes a report of the client. Its values are totals, so a lost report loses no count.
void Session::hear(const HandReport& report) noexcept {
  // After a client has joined again, its totals do not begin at zero. So add only the difference
  // from the first report.
  if (report_)
    counters_.late_ticks += (report.late_ticks - report_->late_ticks) & HandReport::kLateTicksMask;
  report_ = report;
  if (report.times) times_.take(*report.times);
}

/// Counts a gap if a sample that the client sent before this batch has not arrived. A sample that
/// the client did not send makes no gap.
void Session::count_gap(const SampleBatch& batch, Reply& reply) noexcept {
  if (newest_.sample.index == 0 || batch.previous <= newest_.sample.index) return;
  ++counters_.gaps;
  counters_.missed += batch.previous - newest_.sample.index;
  reply.gap = true;
}

Session::Movement Session::movement_to(const Sample& sample, bool rotation) const noexcept {
  Movement movement;
  const double period = parameters_.servo_period;
  movement.nominal_time = movement.elapsed = period;
  if (newest_.sample.index == 0) return movement;

  movement.displacement = sample.pose.position - newest_.sample.pose.position;
  // A rotation is known only if both samples have an orientation.
  if (rotation && newest_.rotation)
    movement.rotation = rotation_between(newest_.sample.pose.orientation, sample.pose.orientation);
  movement.nominal_time = static_cast<double>(sample.index - newest_.sample.index) * period;
  // If the client's clock stands still or runs backwards, use the nominal time.
  const double elapsed = seconds_between(newest_.sample.client_time, sample.client_time);
  movement.elapsed = elapsed > 0.0 ? elapsed : movement.nominal_time;
  return movement;
}

void Session::step(const Sample& sample, bool rotation, Reply& reply) noexcept {
  const Movement movement = movement_to(sample, rotation);

  // Observe the energy that the device gave to the hand since the last received sample, with the
  // force that the client reported (`newest_.sample.held`). It is zero before the first sample.
  observer_.step(newest_.sample.held, movement.displacement, movement.rotation, movement.elapsed);

  // The time for which the last command was held. If the real time is longer than the nominal one,
  // the bound may use it, because the device's damping dissipated energy during all of it.
  const double hold_time = std::max(movement.nominal_time, movement.elapsed);
  // A new bound begins at this sample. The previous bound already counted the energy of the
  // movement to this sample, so the new bound gets no movement.
  const Movement credited = bound_.fresh ? Movement{} : movement;
  bound_.fresh = false;
  Tool tool{sample.pose.position, Vec3::Zero()};
  Pose pose = sample.pose;
  Vec3 tool_moved = movement.displacement;
  if (parameters_.side != BoundingSide::client) {
    const Probe probe = bound_.bounding.probe(credited.displacement, credited.rotation);
    const Vec3& offset = probe.offset;
    tool.position += offset;
    pose = moved(pose, offset, probe.rotation);
    tool_moved += offset - bound_.probe_offset;
    bound_.probe_offset = offset;
  }
  if (place_.view->requirements().velocity) tool.velocity = velocity_.update(tool_moved, hold_time);

  const Command command = actuated(device_, touch(pose, tool, hold_time));
  newest_.outcome.asked = command;
  reply.command = command;
  reply.bound.active = reply.bound.saturated = reply.bound.refused = false;
  reply.bound.ratio = 1.0;
  if (parameters_.side != BoundingSide::client) {
    const Bounded bounded = bound_.bounding.step({.displacement = credited.displacement,
                                                  .rotation = credited.rotation,
                                                  .hold_time = hold_time,
                                                  .command = command});
    reply.command = bounded.rendered;
    reply.bound.active = bounded.active;
    reply.bound.saturated = bounded.saturated;
    reply.bound.refused = bounded.refused;
    reply.bound.ratio = force_ratio(bounded.rendered, command);
  }
  deadband_.add(reply.command, hold_time);
  newest_.sample = sample;
  newest_.rotation = rotation;
  ++counters_.samples;
}

Session::Place::Place(const ToolView& entered, World* run, const HandLimits& limits)
    : view(&entered),
      world(run),
      contacts(entered.memory()),
      body_contacts(run != nullptr ? run->contact_state(entered, limits) : BodyContactState{}) {}

void Session::enter(Place place) noexcept {
  ++reloads_;
  place_ = std::move(place);
  body_ = {};
  forget_surfaces();
  ++scenes_;
  deadband_ = ReplyDeadband(parameters_);  // send the next reply: it is about the new scene
}

void Session::reach_through_arm(bool through) noexcept {
  if (through == through_arm_) return;
  through_arm_ = through;
  for (auto& contact : place_.contacts) contact = {};
  body_ = {};
  place_.body_contacts.fresh = place_.body_contacts.placed = false;
  // No world has so many resets, so the next touch() starts with an empty contact memory.
  place_.body_contacts.resets = ~std::uint64_t{0};
  ++scenes_;  // the client then forgets the contacts of its local model too
  deadband_ = ReplyDeadband(parameters_);
}

void Session::adopt(const ToolView& view, std::size_t object) noexcept {
  ++reloads_;
  const double rubbed = place_.view->objects()[object].material.static_friction;
  if (rubbed == 0.0 && view.objects()[object].material.static_friction > 0.0) {
    place_.contacts[object].touching = place_.contacts[object].slipping = false;
    ++scenes_;  // the client then forgets the contacts of its local model too
  }
  if (!place_.view->requirements().velocity)
    velocity_ = VelocityEstimate(parameters_.velocity_cutoff);
  place_.view = &view;
  body_.known = false;  // its contact was computed with the old material
  // The surfaces that the client of a tool with a body has include the old material.
  if (view.tool().body != nullptr) forget_surfaces();
  deadband_ = ReplyDeadband(parameters_);
}

std::string no_surface(std::uint16_t object) {
  return "object " + std::to_string(object) +
         " has no surface to have in full; list the surfaces to see which there are";
}

std::optional<std::string> Session::take_surfaces(std::uint32_t version,
                                                  const std::vector<std::uint16_t>& objects) {
  KnownSurfaces known(place_.view->objects().size(), false);
  for (const std::uint16_t object : objects) {
    if (!can_travel(*place_.view, object)) return no_surface(object);
    known[object] = true;
  }
  prefetched_.known = std::move(known);
  const BodyTool* body = place_.view->tool().body.get();
  prefetched_.version = (body != nullptr ? can_travel(*body) : !objects.empty()) ? version : 0;
  deadband_ = ReplyDeadband(parameters_);  // send the next reply: its model is different
  return std::nullopt;
}

void Session::weigh_anew() noexcept {
  if (place_.view->tool().body == nullptr) return;
  ++reloads_;
  forget_surfaces();  // the client's copy has the old gravity
  deadband_ = ReplyDeadband(parameters_);
}

void Session::forget_surfaces() noexcept {
  prefetched_.known.clear();
  prefetched_.version = 0;
}

LocalModel Session::model() const noexcept {
  if (!touches()) return {.center = newest_.sample.pose.position, .reach = kModelReach};
  LocalModel model = place_.world != nullptr
                         ? local_model(*place_.world, newest_.sample.pose.position, place_.contacts,
                                       place_.body_contacts.held, prefetched_.known)
                         : local_model(*place_.view, newest_.sample.pose.position, place_.contacts,
                                       prefetched_.known);
  model.surfaces = prefetched_.version;
  return model;
}

BodyModel Session::body_model(int most) const noexcept {
  return place_.world != nullptr
             ? feltwire::body_model(*place_.world, newest_.sample.pose, body_,
                                    place_.body_contacts.held, prefetched_.version,
                                    prefetched_.known, most)
             : feltwire::body_model(*place_.view, newest_.sample.pose, body_, prefetched_.version,
                                    prefetched_.known, most);
}

bool Session::shorten(Reply& reply, std::size_t excess) const noexcept {
  if (reply.modelled && reply.model.count > 0) {
    feltwire::shorten(reply.model, excess);
    return true;
  }
  if (reply.modelled) {
    reply.modelled = false;
    return true;
  }
  if (!reply.body_modelled) return false;
  const std::uint32_t scene = reply.body.scene;
  reply.body = body_model(shortened_points(reply.body, excess));
  reply.body.scene = scene;
  reply.body_modelled = reply.body.reach > 0.0;
  return true;
}

LocalModel Session::surfaces() const noexcept {
  return parameters_.local_model && !observes_ ? model() : LocalModel{};
}

Command Session::touch(const Pose& device, const Tool& tool, double elapsed) noexcept {
  if (!touches()) return {};
  if (place_.view->tool().body)
    return place_.world != nullptr
               ? place_.world->touch(device, tool.velocity, elapsed, body_, place_.body_contacts)
               : place_.view->touch(device, tool.velocity, elapsed, body_);
  return place_.world != nullptr ? place_.world->touch(tool, place_.contacts, place_.body_contacts)
                                 : place_.view->touch(tool, place_.contacts);
}

ProxyPlace Session::proxy() const noexcept {
  const Vec3& tool = newest_.sample.pose.position;
  if (!touches()) return {tool, 0.0};
  if (place_.view->tool().body) {
    const Vec3& held = body_.placed ? body_.pose.position : tool;
    return {held, (held - tool).norm()};
  }
  ProxyPlace proxy{tool, 0.0};
  const std::vector<Object>& objects = place_.world != nullptr
                                           ? place_.world->objects(place_.body_contacts.held)
                                           : place_.view->objects();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!place_.contacts[i].touching) continue;
    FeatureMemory memory = place_.contacts[i].feature;
    const SurfacePoint surface =
        surface_point(objects[i], tool, place_.view->tool().radius, memory);
    const Vec3 out = surface.depth * (objects[i].pose.orientation * surface.normal);
    if (!out.allFinite()) continue;
    proxy.position += out;
    proxy.depth = std::max(proxy.depth, surface.depth);
  }
  return proxy;
}

void Session::push(double age) noexcept {
  if (newest_.sample.index == 0 || !touches())
    return;  // no sample yet, or no contact with the scene
  const double share = std::clamp(2.0 * (1.0 - age / parameters_.hold_time), 0.0, 1.0);
  if (!(share > 0.0)) return;
  if (place_.view->tool().body)
    place_.world->push(place_.body_contacts, body_, share);
  else
    place_.world->push(place_.body_contacts, place_.contacts, share);
}

void Session::put_law(SessionParameters& parameters) noexcept {
  std::swap(parameters_, parameters);
  sends_normals_ = shapes_at_client(parameters_);
}

void Session::set_parameters(const SessionParameters& parameters) {
  validate(parameters);
  if (parameters.servo_period != parameters_.servo_period)
    throw std::invalid_argument(
        "servo_period cannot change while a session runs; leave and join again");

  if (!same_bound(parameters, parameters_)) {
    bound_ = {.bounding = Bounding(bounding_config(parameters, device_)), .fresh = true};
  }
  if (parameters.velocity_cutoff != parameters_.velocity_cutoff)
    velocity_ = VelocityEstimate(parameters.velocity_cutoff);
  parameters_ = parameters;
  sends_normals_ = shapes_at_client(parameters);
  deadband_ = ReplyDeadband(parameters);
}

}  // namespace feltwire
