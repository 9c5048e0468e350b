#include "sim/studies/extremes/contact_extremes.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/mesh/thin_solid.hpp"
#include "core/scene/scene.hpp"
#include "sim/studies/extremes/pressed_shapes.hpp"

namespace feltwire {
namespace {

constexpr int kPressSteps = 12;                        // from the free side to the deepest place
constexpr double kApproach = 0.3;                      // [sizes] distance at which a tool begins
constexpr double kPressDepth = 0.05;                   // [sizes] of the deepest place
constexpr double kSmallBall = 0.1, kLargeBall = 10.0;  // [sizes] radius

// Largest errors, as shares of stiffness times size. A product and a rotation round some ten times;
// a cone has two roots more. A mesh keeps its skin, which single-precision coordinates cannot tell
// apart. A grid has its distances in float.
constexpr double kForceRounding = 64.0 * std::numeric_limits<double>::epsilon();
constexpr double kFloatRounding = 64.0 * std::numeric_limits<float>::epsilon();

double allowed_error(const PressedShape& pressed) {
  return pressed.name == "mesh" || pressed.name == "grid" ? kFloatRounding : kForceRounding;
}

/// A tool against one shape.
struct Press {
  Side side = Side::outside;
  double radius = 0.0;  // [m] of the ball; 0: a point
  double origin = 0.0;  // [m] place of the object, on each axis
  Material material{};
  double speed = 0.0;  // [m/s] that the tool is said to have, into and along the surface
};

/// The scene of one object, a hand in it, and the truth about the place of the hand.
class PressedScene {
 public:
  PressedScene(const PressedShape& pressed, const Press& press)
      : pressed_(pressed), press_(press), scene_("extremes", {object()}) {
    if (press.radius > 0.0) scene_.set_tool({.radius = press.radius, .body = {}});
    memory_ = scene_.memory();
  }

  /// [m, world] The place at a height above the surface, as the tool has it.
  Vec3 above(double height) const {
    const Pose& pose = scene_.objects()[0].pose;
    return pose.position + pose.orientation * (pressed_.place + height * pressed_.normal);
  }
  /// [m] The depth of the tool at a place, and the unit normal towards the free side, world frame.
  SurfaceTruth truth_at(const Vec3& place) const {
    const Pose& pose = scene_.objects()[0].pose;
    const auto turn = pose.orientation.cast<long double>().normalized();
    const LongVec3 own =
        turn.conjugate() * (place.cast<long double>() - pose.position.cast<long double>());
    const SurfaceTruth found = pressed_.truth(own);
    const long double sign = press_.side == Side::outside ? 1.0L : -1.0L;
    return {static_cast<long double>(press_.radius) - sign * found.distance,
            sign * (turn * found.normal)};
  }
  Command touch(const Vec3& place, const Vec3& velocity = Vec3::Zero()) {
    return scene_.touch({place, velocity}, memory_);
  }
  /// False near the middle of a round shape: there the proxy may stay behind, or has no normal.
  bool has_closed_form(const SurfaceTruth& truth) const {
    constexpr long double kDeepest = 0.35L;  // of the thickness
    const auto depth = truth.distance - static_cast<long double>(press_.radius);
    return truth.normal.allFinite() &&
           (pressed_.flat || depth < kDeepest * static_cast<long double>(pressed_.thickness));
  }
  /// [m] The largest length that the contact at a place computes with.
  double extent_at(const Vec3& place) const {
    return pressed_.size + press_.radius + length(Vec3(place - scene_.objects()[0].pose.position));
  }
  const Press& press() const { return press_; }
  const PressedShape& pressed() const { return pressed_; }
  /// [m] The height at which the tool touches the surface, on the free side, and one size away.
  double free_sign() const { return press_.side == Side::outside ? 1.0 : -1.0; }

 private:
  Object object() const {
    Object object;
    object.name = pressed_.name;
    object.shape = pressed_.shape;
    object.felt_from = press_.side;
    object.pose = {Vec3::Constant(press_.origin),
                   Quaternion(Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()))};
    object.material = press_.material;
    return object;
  }

  const PressedShape& pressed_;
  Press press_;
  Scene scene_;
  TouchMemory memory_;
};

/// Judges the command at a place against the closed form: the elastic force, its friction limit,
/// and whether it is there at all.
void judge_command(const PressedScene& scene, const Vec3& place, const Vec3& velocity,
                   const Command& command, ExtremeCell& cell) {
  const SurfaceTruth truth = scene.truth_at(place);
  if (!scene.has_closed_form(truth)) {
    cell.judge(command.finite(), 0.0);
    return;
  }
  const Material& material = scene.press().material;
  const long double depth = std::max(0.0L, truth.distance);
  const LongVec3 wanted =
      static_cast<long double>(cell.assumed_scale * material.stiffness) * depth * truth.normal;
  const double scale = material.stiffness * scene.extent_at(place);
  const LongVec3 missing = command.elastic.cast<long double>() - wanted;
  const auto error = static_cast<double>(missing.norm() / static_cast<long double>(scale));
  // Dry friction, viscous friction, and a damping that never pulls harder than the spring pushes.
  const double elastic = length(command.elastic), speed = length(velocity);
  const double limit = material.static_friction * elastic + material.viscous_friction * speed +
                       std::max(elastic, material.damping * speed);
  const bool within = length(command.frictional) <= limit * (1.0 + kForceRounding);
  cell.judge(command.finite(), error, within);
  const bool deep =
      truth.distance > static_cast<long double>(cell.allowed * scale / material.stiffness);
  if (deep && command.elastic.isZero(0.0)) ++cell.holes;
}

/// Presses a tool into the surface, step by step.
void press_in(PressedScene& scene, double depth, ExtremeCell& cell) {
  const double size = scene.pressed().size, radius = scene.press().radius;
  const Vec3 sideways = scene.above(0.0) - scene.above(1.0);  // [m] one metre into the surface
  for (int step = 0; step <= kPressSteps; ++step) {
    const double share = static_cast<double>(step) / kPressSteps;
    const double gap = (1.0 - share) * kApproach * size - share * depth;
    const Vec3 place = scene.above(scene.free_sign() * (radius + gap));
    const Vec3 velocity = scene.press().speed * direction(Vec3(sideways + Vec3(0.3, 0.1, -0.2)));
    judge_command(scene, place, velocity, scene.touch(place, velocity), cell);
  }
}

/// Adds a row of contacts: each shape is one cell.
template <class Judge>
void add_pressed_row(ExtremeMatrix& matrix, const std::string& stress,
                     const std::vector<PressedShape>& shapes, const Judge& judge) {
  add_shape_row(matrix, stress,
                "force against the closed form, over stiffness times size and distance", shapes,
                allowed_error, judge);
}

void add_sizes(ExtremeMatrix& matrix, double origin) {
  const std::string place = origin > 0.0 ? "; at 1e6 m" : "";
  for (const double size : kExtremeSizes) {
    const std::vector<PressedShape> shapes = shapes_of_size(size);
    add_pressed_row(matrix, stress_name("size", size, "m") + place, shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      for (const Side side : {Side::outside, Side::inside}) {
                        PressedScene scene(pressed, {.side = side, .origin = origin});
                        press_in(scene, kPressDepth * size, cell);
                      }
                    });
    add_pressed_row(matrix, stress_name("ball on", size, "m") + place, shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      for (const Side side : {Side::outside, Side::inside}) {
                        PressedScene scene(
                            pressed, {.side = side, .radius = kSmallBall * size, .origin = origin});
                        press_in(scene, kPressDepth * size, cell);
                      }
                    });
  }
}

void add_large_balls(ExtremeMatrix& matrix) {
  for (const double size : {1e-9, 1.0, 1e5})
    add_pressed_row(matrix, stress_name("ball 10 times", size, "m"), shapes_of_size(size),
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      PressedScene scene(pressed, {.radius = kLargeBall * size});
                      press_in(scene, kPressDepth * size, cell);
                    });
}

void add_materials(ExtremeMatrix& matrix) {
  const std::vector<PressedShape> shapes = shapes_of_size(1.0);
  for (const double stiffness : kExtremeStiffnesses)
    add_pressed_row(matrix, stress_name("stiffness", stiffness, "N/m"), shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      for (const double friction : {0.5, 100.0})
                        for (const double damping : {1.0, 1e6})
                          for (const double speed : {0.0, 1.0, 1e3}) {
                            const Material material{.stiffness = stiffness,
                                                    .damping = damping,
                                                    .static_friction = friction,
                                                    .dynamic_friction = 0.8 * friction,
                                                    .viscous_friction = damping};
                            PressedScene scene(pressed, {.material = material, .speed = speed});
                            press_in(scene, kPressDepth, cell);
                          }
                    });
}

void add_proportions(ExtremeMatrix& matrix) {
  constexpr double kThin = 1e-9, kWide = 1e6;  // [m]
  const auto judge = [](const PressedShape& pressed, ExtremeCell& cell) {
    if (const auto* mesh = std::get_if<Mesh>(&pressed.shape))
      cell.warned = warning_of_thin_solid(*mesh->surface).value_or("");
    PressedScene scene(pressed, {});
    press_in(scene, kPressDepth * pressed.size, cell);
    if (!pressed.flat) return;
    // A flat face holds a tool that is pressed through the plate and beyond it.
    PressedScene through(pressed, {});
    press_in(through, 1e3 * pressed.thickness, cell);
  };
  add_pressed_row(matrix, "plate 1e-9 m; 1e6 m wide", plates(kThin, kWide), judge);
  add_pressed_row(matrix, "rod 1e-9 m; 1e6 m long", rods(kThin, kWide), judge);
}

/// Goes in one step from the free side to a place behind the shape: the tool must be held.
void add_one_step(ExtremeMatrix& matrix) {
  for (const double size : {1e-9, 1.0, 1e6}) {
    std::vector<PressedShape> shapes = shapes_of_size(size);
    shapes.pop_back();  // a grid remembers no face
    add_pressed_row(matrix, stress_name("one step through", size, "m"), shapes,
                    [&](const PressedShape& pressed, ExtremeCell& cell) {
                      PressedScene scene(pressed, {});
                      scene.touch(scene.above(kApproach * size));
                      const Vec3 place = scene.above(-1.1 * pressed.thickness);
                      const Command command = scene.touch(place);
                      const Vec3 out = scene.above(size) - scene.above(0.0);
                      if (!(command.elastic.dot(out) > 0.0)) ++cell.holes;
                      if (pressed.flat)
                        judge_command(scene, place, Vec3::Zero(), command, cell);
                      else
                        cell.judge(command.finite(), 0.0);
                    });
  }
}

/// A tool that is nowhere feels nothing, and is felt again when it comes back.
void add_impossible_places(ExtremeMatrix& matrix) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  add_pressed_row(
      matrix, "tool at NaN; Inf; 1e300 m", shapes_of_size(1.0),
      [&](const PressedShape& pressed, ExtremeCell& cell) {
        for (const double radius : {0.0, kSmallBall})
          for (const double strange : {kNan, kInfinity, -kInfinity, 1e300, -1e300, 1e154}) {
            PressedScene scene(pressed, {.radius = radius});
            for (int axis = 0; axis < 3; ++axis) {
              const Vec3 free = scene.above(radius + kApproach);
              Vec3 place = free;
              place[axis] = strange;
              const Command command = scene.touch(place);
              cell.judge(command.finite(), 0.0);
              if (!std::isfinite(strange) && !command.force().isZero(0.0)) ++cell.over_limit;
            }
            // A place that is no place leaves the memory unchanged: the hand goes on.
            if (!std::isfinite(strange)) press_in(scene, kPressDepth, cell);
          }
      });
}

}  // namespace

ExtremeMatrix run_contact_extremes(double assumed_scale) {
  ExtremeMatrix matrix{.part = "contact",
                       .title = "worst error of the force, over stiffness times size",
                       .assumed_scale = assumed_scale};
  for (const double origin : {0.0, kFarOrigin}) add_sizes(matrix, origin);
  add_large_balls(matrix);
  add_materials(matrix);
  add_proportions(matrix);
  add_one_step(matrix);
  add_impossible_places(matrix);
  return matrix;
}

}  // namespace feltwire
