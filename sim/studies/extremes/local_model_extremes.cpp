#include "sim/studies/extremes/local_model_extremes.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene/scene.hpp"
#include "protocol/wire/codec.hpp"
#include "sim/studies/extremes/pressed_shapes.hpp"

namespace feltwire {
namespace {

constexpr double kServoPeriod = 1e-3;  // [s]
constexpr double kModelDepth = 0.05;   // [sizes]
constexpr double kAside = 1e-3;        // [sizes] movement of the tool after the model

// Lengths of a model are float32, relative to its centre, and its places have the digits of a
// double. A patch is curved to second order: a movement of kAside over a shape whose curvature
// changes is wrong by some kAside squared, and over a torus, which is curved in two ways, by more.
constexpr double kDigit = 8.0 * std::numeric_limits<double>::epsilon();
constexpr double kModelRounding = 64.0 * std::numeric_limits<float>::epsilon();

double model_error(const PressedShape& pressed, double origin) {
  const double bends = pressed.name == "torus" ? 32.0 : 1.0;
  return kModelRounding + bends * kAside * kAside + kDigit * origin / pressed.size;
}

struct Sent {
  double radius = 0.0;  // [m] of the tool; 0: a point
  double origin = 0.0;  // [m] place of the object, on each axis
  Material material{};
};

/// The model after the wire, or nothing if the client drops it.
std::optional<LocalModel> after_wire(const LocalModel& model) {
  Encoder encoder;
  Reply reply, received;
  reply.sample_index = 1;
  reply.modelled = true;
  reply.model = model;
  if (decode(encoder.reply(reply), received) != DropReason::none) return std::nullopt;
  return received.model;
}

/// Judges the force of the model at a place against that of the scene.
void judge_model(const Scene& scene, TouchMemory& memory, LocalContact& contact, const Vec3& place,
                 double scale, ExtremeCell& cell) {
  const Command felt = scene.touch({place, Vec3::Zero()}, memory);
  const LocalForce local = contact.touch({place, Vec3::Zero()}, 0.0, kServoPeriod);
  // A model of weight 0 gives no force: then the reply is rendered.
  if (!(local.weight > 0.0)) {
    cell.judge(local.command.finite(), 0.0);
    return;
  }
  const double error =
      length(Vec3(local.command.elastic - cell.assumed_scale * felt.elastic)) / scale;
  cell.judge(local.command.finite(), error, local.weight <= 1.0);
  if (length(felt.elastic) > cell.allowed * scale && local.command.elastic.isZero(0.0))
    ++cell.holes;
}

void send_model(const PressedShape& pressed, const Sent& sent, ExtremeCell& cell) {
  Object object;
  object.name = pressed.name;
  object.shape = pressed.shape;
  object.pose = {Vec3::Constant(sent.origin),
                 Quaternion(Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()))};
  object.material = sent.material;
  Scene scene("extremes", {object});
  if (sent.radius > 0.0) scene.set_tool({.radius = sent.radius, .body = {}});
  const Pose& pose = scene.objects()[0].pose;
  const auto above = [&](double height, double aside) {
    const Vec3 tangent = direction(pressed.normal.cross(Vec3(0.3, -0.2, 0.9)));
    return Vec3(pose.position + pose.orientation * (pressed.place + aside * tangent +
                                                    (sent.radius + height) * pressed.normal));
  };
  const double scale = sent.material.stiffness * (pressed.size + sent.radius);
  const double depth = kModelDepth * pressed.size;
  // Free, touching, and deep: a model each, and a movement after it.
  for (const double height : {0.5 * depth, -0.2 * depth, -depth}) {
    TouchMemory memory = scene.memory();
    scene.touch({above(depth, 0.0), Vec3::Zero()}, memory);
    const Vec3 center = above(height, 0.0);
    scene.touch({center, Vec3::Zero()}, memory);
    const std::optional<LocalModel> model = after_wire(local_model(scene, center, memory));
    if (!model) {
      ++cell.holes;
      continue;
    }
    LocalContact contact;
    contact.take(*model);
    judge_model(scene, memory, contact, center, scale, cell);
    for (const double aside : {kAside, -kAside})
      judge_model(scene, memory, contact,
                  above(height + aside * pressed.size, aside * pressed.size), scale, cell);
  }
}

/// Adds a row of models: each shape is one cell.
template <class Judge>
void add_model_row(ExtremeMatrix& matrix, const std::string& stress, double origin,
                   const std::vector<PressedShape>& shapes, const Judge& judge) {
  add_shape_row(
      matrix, stress, "model's force against the scene's, over stiffness times size", shapes,
      [origin](const PressedShape& pressed) { return model_error(pressed, origin); }, judge);
}

/// A model from a hostile server: each of its numbers in turn is at the end of its range.
void add_hostile(ExtremeMatrix& matrix) {
  constexpr std::array kStrange = {0.0, 1e-300, 1e300, -1e300, 1e38};
  ExtremeCell cell{.stress = "numbers of 1e-300; 1e300",
                   .judged = "plane",
                   .reference = "finite",
                   .allowed = 0.0};
  for (int field = 0; field < 12; ++field)
    for (const double strange : kStrange) {
      LocalModel model;
      model.reach = 0.1;
      model.count = 1;
      SurfacePatch& patch = model.patches[0];
      patch.radius = 1.0;
      patch.touching = true;
      patch.material = {.static_friction = 0.5, .dynamic_friction = 0.4};
      const std::array<double*, 12> numbers = {&patch.point.x(),
                                               &patch.point.z(),
                                               &patch.anchor.x(),
                                               &patch.curvature,
                                               &patch.velocity.x(),
                                               &patch.velocity.z(),
                                               &patch.radius,
                                               &patch.offset,
                                               &patch.material.stiffness,
                                               &patch.material.damping,
                                               &patch.material.viscous_friction,
                                               &model.reach};
      *numbers[static_cast<std::size_t>(field)] = strange;
      LocalContact contact;
      contact.take(model);
      for (const double depth : {0.0, 1e-3, 0.05, 1e-300})
        for (const double speed : {0.0, 1.0, 1e300}) {
          const LocalForce force =
              contact.touch({Vec3(0.0, 0.0, -depth), Vec3::Constant(speed)}, 0.01, kServoPeriod);
          cell.judge(force.command.finite() && std::isfinite(force.weight), 0.0,
                     force.weight >= 0.0 && force.weight <= 1.0);
        }
    }
  matrix.cells.push_back(std::move(cell));
}

}  // namespace

ExtremeMatrix run_local_model_extremes(double assumed_scale) {
  ExtremeMatrix matrix{.part = "local",
                       .title = "worst error of a local model's force, over stiffness times size",
                       .assumed_scale = assumed_scale};
  for (const double origin : {0.0, kFarOrigin})
    for (const double size : kExtremeSizes) {
      const std::vector<PressedShape> shapes = shapes_of_size(size);
      const std::string place = origin > 0.0 ? "; at 1e6 m" : "";
      const double ball = 0.1 * size;
      add_model_row(matrix, stress_name("size", size, "m") + place, origin, shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      send_model(pressed, {.origin = origin}, cell);
                    });
      add_model_row(matrix, stress_name("ball on", size, "m") + place, origin, shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      send_model(pressed, {.radius = ball, .origin = origin}, cell);
                    });
    }
  const std::vector<PressedShape> shapes = shapes_of_size(0.1);
  for (const double stiffness : kExtremeStiffnesses)
    add_model_row(matrix, stress_name("stiffness", stiffness, "N/m"), 0.0, shapes,
                  [&](const PressedShape& pressed, ExtremeCell& cell) {
                    const Material material{.stiffness = stiffness,
                                            .damping = 1.0,
                                            .static_friction = 100.0,
                                            .dynamic_friction = 80.0};
                    send_model(pressed, {.material = material}, cell);
                  });
  add_hostile(matrix);
  return matrix;
}

}  // namespace feltwire
