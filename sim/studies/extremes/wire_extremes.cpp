#include "sim/studies/extremes/wire_extremes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/base/numeric.hpp"
#include "core/device/device_spec.hpp"
#include "core/scene/scene.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/sequence.hpp"
#include "server/scene/session.hpp"

namespace feltwire {
namespace {

constexpr std::array kPlaces = {0.0, 1e-9, 1.0, 1e3, 1e6};      // [m] on each axis
constexpr std::array kForces = {1e-9, 1.0, 1e3, 1e6, 1e12};     // [N] on each axis
constexpr std::array kPeriods = {10.0, 0.1, 1e-3, 1e-5, 1e-6};  // [s]
constexpr double kFloatStep = 0.5 * std::numeric_limits<float>::epsilon();
// A vector has three rounded components, and its length is rounded, too.
constexpr double kVectorRounding = 2.0 * kFloatStep;
constexpr double kDoubleRounding = 4.0 * std::numeric_limits<double>::epsilon();

/// A value on an axis that no type represents exactly.
Vec3 vector_of(double size) { return size * Vec3(1.0, 1.0 - 1.0 / 3.0, -1.0 / 7.0); }
Quaternion some_turn() {
  return Quaternion(Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()));
}

/// [m], [N] The length of the difference of two vectors.
double difference_of(const Vec3& a, const Vec3& b) { return length(Vec3(a - b)); }

ExtremeCell wire_cell(const ExtremeMatrix& matrix, const std::string& stress, const char* judged,
                      double allowed,
                      const char* reference = "value after the wire against before [m]") {
  return {.stress = stress,
          .judged = judged,
          .reference = reference,
          .allowed = allowed,
          .assumed_scale = matrix.assumed_scale};
}

/// Judges a decoded vector, or notes the reason for which the receiver drops the datagram. Only a
/// place beyond the documented range may be dropped.
void judge_received(DropReason drop, const char* field, const Vec3& sent, const Vec3& received,
                    bool in_range, ExtremeCell& cell) {
  if (drop == DropReason::none) {
    cell.judge(received.allFinite(), difference_of(cell.assumed_scale * sent, received), in_range);
    return;
  }
  if (in_range)
    ++cell.holes;
  else
    cell.refused = std::string(field) + ": dropped as " + name(drop) + ", farther than " +
                   std::to_string(static_cast<int>(kMaxPosition)) + " m from the origin";
  ++cell.checks;
}

SampleBatch batch_of(const Vec3& place, std::uint64_t index = 5,
                     Nanoseconds time = Nanoseconds(7)) {
  SampleBatch batch;
  batch.count = 1;
  batch.rotation = true;
  batch.previous = index - 1;
  Sample& sample = batch.samples[0];
  sample.index = index;
  sample.client_time = time;
  sample.pose = {place, some_turn()};
  return batch;
}

Reply reply_of() {
  Reply reply;
  reply.sample_index = 5;
  return reply;
}

/// A model of one surface, `away` from the tool.
LocalModel model_of(const Vec3& center, const Vec3& away) {
  LocalModel model;
  model.center = center;
  model.reach = 0.1;
  model.count = 1;
  model.patches[0].point = center + away;
  model.patches[0].anchor = center + 2.0 * away;
  model.patches[0].radius = 1.0;
  return model;
}

SceneView view_of(const Vec3& place) {
  SceneView view;
  view.present = true;
  view.hands_end = SceneView::kLastHand;
  view.bodies_end = SceneView::kLastBody;
  view.hand_count = view.body_count = 1;
  view.hand[0] = {.number = 1, .pose = {place, some_turn()}, .force = Vec3::Zero()};
  view.body[0] = {.object = 1, .pose = {place, some_turn()}};
  return view;
}

void add_places(ExtremeMatrix& matrix) {
  Encoder encoder;
  for (const double size : kPlaces) {
    const std::string stress = stress_name("place", size, "m");
    const Vec3 place = vector_of(size);
    const bool in_range = size <= kMaxPosition;
    const double float_step = kVectorRounding * length(place);

    ExtremeCell sample = wire_cell(matrix, stress, "sample", 0.0);
    SampleBatch batch;
    const DropReason dropped = decode(encoder.samples(batch_of(place)), batch);
    judge_received(dropped, "sample.position", place, batch.samples[0].pose.position, in_range,
                   sample);
    matrix.cells.push_back(sample);

    // The offset of a lead is subtracted from the place of the hand: it moves a robot's target.
    ExtremeCell lead = wire_cell(matrix, stress, "lead", float_step);
    SampleBatch leading = batch_of(Vec3::Zero());
    leading.lead = Lead{.offset = place};
    SampleBatch led;
    const DropReason lead_dropped = decode(encoder.samples(leading), led);
    judge_received(lead_dropped, "lead.offset", place, led.lead.value_or(Lead{}).offset, in_range,
                   lead);
    matrix.cells.push_back(lead);

    // A model's lengths are relative to its centre, so its error does not grow with the place.
    constexpr double kAway = 0.1;  // [m]
    ExtremeCell model = wire_cell(matrix, stress, "model",
                                  kVectorRounding * 2.0 * kAway + kDoubleRounding * length(place));
    Reply reply = reply_of(), received;
    reply.modelled = true;
    reply.model = model_of(place, vector_of(kAway));
    const DropReason model_dropped = decode(encoder.reply(reply), received);
    for (const auto& [sent, got] :
         {std::pair(reply.model.patches[0].point, received.model.patches[0].point),
          std::pair(reply.model.patches[0].anchor, received.model.patches[0].anchor),
          std::pair(reply.model.center, received.model.center)})
      judge_received(model_dropped, "model.center", sent, got, true, model);
    matrix.cells.push_back(model);

    ExtremeCell hand = wire_cell(matrix, stress, "seen hand", float_step);
    ExtremeCell body = wire_cell(matrix, stress, "seen body", float_step);
    const SceneView view = view_of(place);
    SceneView seen;
    const DropReason view_dropped = decode(encoder.reply(reply_of(), &view), received, &seen);
    judge_received(view_dropped, "view.hands", place, seen.hand[0].pose.position, true, hand);
    judge_received(view_dropped, "view.bodies", place, seen.body[0].pose.position, true, body);
    matrix.cells.push_back(hand);
    matrix.cells.push_back(body);

    ExtremeCell robot = wire_cell(matrix, stress, "robot", 0.0);
    RobotState state, state_read;
    state.index = 1;
    state.pose = state.commanded = {place, some_turn()};
    state.contact = {.surface = 1, .touching = true, .point = place, .stiffness = 1e9};
    const DropReason state_dropped = decode(encoder.state(state), state_read);
    judge_received(state_dropped, "state.position", place, state_read.pose.position, in_range,
                   robot);
    if (state_dropped == DropReason::none)
      judge_received(state_dropped, "state.contact", place, state_read.contact.point, in_range,
                     robot);
    matrix.cells.push_back(robot);

    ExtremeCell target = wire_cell(matrix, stress, "target", 0.0);
    RobotTarget wanted, wanted_read;
    wanted.index = 1;
    wanted.pose = {place, some_turn()};
    const DropReason target_dropped = decode(encoder.target(wanted), wanted_read);
    judge_received(target_dropped, "target.position", place, wanted_read.pose.position, in_range,
                   target);
    matrix.cells.push_back(target);
  }
}

void add_forces(ExtremeMatrix& matrix) {
  Encoder encoder;
  for (const double size : kForces) {
    const std::string stress = stress_name("force", size, "N");
    const Vec3 force = vector_of(size);
    constexpr const char* kReference = "force after the wire against before, over the force";

    ExtremeCell held = wire_cell(matrix, stress, "sample", kVectorRounding, kReference);
    SampleBatch batch = batch_of(Vec3::Zero()), received;
    batch.samples[0].held = {force, -force, 0.01 * force};
    if (decode(encoder.samples(batch), received) != DropReason::none) ++held.holes;
    const Command& got = received.samples[0].held;
    for (const double error :
         {difference_of(got.elastic, force), difference_of(got.frictional, -force),
          100.0 * difference_of(got.torque, 0.01 * force)})
      held.judge(got.finite(), error / length(force));
    matrix.cells.push_back(held);

    ExtremeCell answered = wire_cell(matrix, stress, "reply", 0.0, kReference);
    Reply reply = reply_of(), reply_read;
    reply.command = {force, -force, 0.01 * force};
    reply.rotation = true;
    if (decode(encoder.reply(reply), reply_read) != DropReason::none) ++answered.holes;
    answered.judge(reply_read.command.finite(),
                   difference_of(reply_read.command.elastic, force) / length(force));
    matrix.cells.push_back(answered);
  }
}

/// Materials and curvatures of a model. A scene may hold every one of them, so none may be dropped.
void add_models(ExtremeMatrix& matrix) {
  Encoder encoder;
  const auto judge = [&](const std::string& stress, const SurfacePatch& patch, double sent,
                         double SurfacePatch::*number) {
    ExtremeCell cell =
        wire_cell(matrix, stress, "model", kVectorRounding, "number after the wire, relative");
    Reply reply = reply_of(), received;
    reply.modelled = true;
    reply.model = model_of(Vec3::Zero(), vector_of(0.01));
    const Vec3 point = reply.model.patches[0].point;
    reply.model.patches[0] = patch;
    reply.model.patches[0].point = reply.model.patches[0].anchor = point;
    if (decode(encoder.reply(reply), received) != DropReason::none) ++cell.holes;
    const SurfacePatch& got = received.model.patches[0];
    const double value = number != nullptr ? got.*number : got.material.stiffness;
    // Beyond float32 a number becomes the end of its range: a drop would lose the whole reply.
    const double wanted = std::clamp(cell.assumed_scale * sent,
                                     static_cast<double>(std::numeric_limits<float>::denorm_min()),
                                     static_cast<double>(std::numeric_limits<float>::max()));
    cell.judge(std::isfinite(value), std::abs(value - wanted) / wanted);
    matrix.cells.push_back(cell);
  };
  for (const double stiffness : {1e-300, 1e-3, 1e3, 1e9}) {
    SurfacePatch patch;
    patch.material.stiffness = stiffness;
    patch.radius = 1.0;
    judge(stress_name("stiffness", stiffness, "N/m"), patch, stiffness, nullptr);
  }
  for (const double radius : {1e-300, 1e-9, 1e-3, 1e6}) {
    SurfacePatch patch;
    patch.curvature = 1.0 / radius;
    patch.radius = radius;
    judge(stress_name("radius", radius, "m"), patch, 1.0 / radius, &SurfacePatch::curvature);
  }
}

constexpr double kWallStiffness = 1e3;  // [N/m]

/// A session of a hand that the server bounds, on a plane.
Session session_on(const Scene& scene, double period) {
  control::JoinRequest request;
  request.client = "extremes";
  request.device = builtin_device("simulated");
  request.parameters = {};
  request.parameters.mode = "none";
  request.parameters.side = BoundingSide::server;
  request.parameters.servo_period = period;
  request.parameters.hold_time = std::max(request.parameters.hold_time, period);
  return {request, scene};
}

Scene plane_scene() {
  Object plane;
  plane.name = "plane";
  plane.shape = Plane{};
  plane.material = {.stiffness = kWallStiffness, .damping = 1e-3, .static_friction = 0.5};
  return Scene("extremes", {plane});
}

/// Presses a hand into a plane: the elastic force against stiffness times depth.
void press_plane(Session& session, std::uint64_t first_index, const std::vector<Nanoseconds>& times,
                 ExtremeCell& cell) {
  std::uint64_t index = first_index;
  for (const Nanoseconds time : times) {
    const double depth = 1e-3 * static_cast<double>(1 + cell.checks % 3);
    const BatchResult taken =
        session.take(batch_of(Vec3(0.0, 0.0, -depth), index++, time), Nanoseconds(0));
    if (taken.drop != DropReason::none) ++cell.holes;
    const Command& command = taken.reply.command;
    // A time that jumps by centuries is refused: no force in that sample.
    if (taken.reply.bound.refused) {
      cell.judge(command.finite(), 0.0, command.force().isZero(0.0));
      continue;
    }
    // Dry friction and a damping that never pulls.
    const bool within = length(command.frictional) <= 1.6 * kWallStiffness * depth;
    cell.judge(command.finite(), std::abs(command.elastic.z() / (kWallStiffness * depth) - 1.0),
               within);
  }
}

/// Runs a session, or notes why it was refused.
template <class Run>
void add_session(ExtremeMatrix& matrix, const std::string& stress, double period, const Run& run) {
  ExtremeCell cell = wire_cell(matrix, stress, "session", kDoubleRounding,
                               "force against stiffness times depth, relative");
  const Scene scene = plane_scene();
  try {
    Session session = session_on(scene, period);
    run(session, cell);
  } catch (const std::invalid_argument& error) {
    cell.refused = error.what();
    if (cell.refused.find(':') == std::string::npos) cell.refused = "session: " + cell.refused;
  }
  matrix.cells.push_back(std::move(cell));
}

void add_rates(ExtremeMatrix& matrix) {
  for (const double period : kPeriods)
    add_session(matrix, stress_name("rate", 1.0 / period, "Hz"), period,
                [&](Session& session, ExtremeCell& cell) {
                  std::vector<Nanoseconds> times(1000);
                  for (std::size_t n = 0; n < times.size(); ++n)
                    times[n] = from_seconds(static_cast<double>(n) * period);
                  press_plane(session, 1, times, cell);
                });
}

void add_wraps(ExtremeMatrix& matrix) {
  constexpr auto kLast = std::numeric_limits<std::uint64_t>::max();
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max(),
                 kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMillisecond = 1'000'000;
  add_session(matrix, "index up to 2^64 - 1", 1e-3, [&](Session& session, ExtremeCell& cell) {
    std::vector<Nanoseconds> times(16);
    for (std::size_t n = 0; n < times.size(); ++n)
      times[n] = Nanoseconds(static_cast<std::int64_t>(n) * kMillisecond);
    press_plane(session, kLast - 15, times, cell);
    // The last index is not followed by another: a sample that begins anew is stale, not taken.
    if (session.take(batch_of(Vec3::Zero(), 1), Nanoseconds(0)).drop != DropReason::stale)
      ++cell.over_limit;
  });
  add_session(matrix, "time wraps", 1e-3, [&](Session& session, ExtremeCell& cell) {
    std::vector<Nanoseconds> times;
    for (int n = 8; n > 0; --n) times.emplace_back(kMost - n * kMillisecond);
    for (int n = 0; n < 8; ++n) times.emplace_back(kLeast + n * kMillisecond);
    press_plane(session, 1, times, cell);
  });
  add_session(matrix, "time jumps", 1e-3, [&](Session& session, ExtremeCell& cell) {
    press_plane(session, 1,
                {Nanoseconds(0), Nanoseconds(kMost), Nanoseconds(kLeast), Nanoseconds(0),
                 Nanoseconds(kLeast), Nanoseconds(kMost), Nanoseconds(0), Nanoseconds(0)},
                cell);
  });

  ExtremeCell window =
      wire_cell(matrix, "index up to 2^64 - 1", "window", 0.0, "numbers taken twice");
  PacketWindow seen(kLast - 2000);
  for (std::uint64_t n = kLast - 1999; n != 0; ++n) {
    if (!seen.fresh(n)) ++window.holes;
    if (seen.fresh(n)) seen.mark(n);
    window.judge(true, seen.fresh(n) ? 1.0 : 0.0, !seen.fresh(0) && !seen.fresh(kLast - 3100));
  }
  matrix.cells.push_back(window);

  ExtremeCell totals = wire_cell(matrix, "counts wrap at 2^16", "hand times", 0.0, "counts lost");
  HandTimesHeard heard;
  HandTimes said;
  std::uint64_t counted = 0;
  heard.take(said);
  for (int n = 0; n < 200; ++n) {
    constexpr std::uint16_t kMore = 60'000;
    said.wakeups[3] = static_cast<std::uint16_t>(said.wakeups[3] + kMore);
    counted += kMore;
    heard.take(said);
    totals.judge(true, heard.wakeups()[3] == counted ? 0.0 : 1.0);
  }
  matrix.cells.push_back(totals);
}

}  // namespace

ExtremeMatrix run_wire_extremes(double assumed_scale) {
  ExtremeMatrix matrix{.part = "wire",
                       .title = "worst difference of a value after the wire; places in metres",
                       .assumed_scale = assumed_scale};
  add_places(matrix);
  add_forces(matrix);
  add_models(matrix);
  add_rates(matrix);
  add_wraps(matrix);
  return matrix;
}

}  // namespace feltwire
