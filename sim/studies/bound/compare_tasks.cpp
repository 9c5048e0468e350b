#include "sim/studies/bound/compare_tasks.hpp"

#include "core/scene_file/load_scene.hpp"
#include "scenes/paper_sphere_text.hpp"
#include "scenes/paper_wall_text.hpp"
#include "sim/measure/surfaces.hpp"
#include "sim/studies/bound/figures.hpp"

namespace feltwire {
namespace {

constexpr double kStiffness = 5000.0;  // [N/m] stiffness of the surfaces defined in this file

CompareTask wall() {
  const Scene scene = parse_scene(embedded::paper_wall, "paper_wall.json");
  return {"wall", environment(scene.objects().front()), [](const Vec3& p) { return p.y(); },
          figure_setup("wall", kUnbounded, 0.0).hand.task, 8.0};
}

CompareTask sphere() {
  const Scene scene = parse_scene(embedded::paper_sphere, "paper_sphere.json");
  return {"sphere", environment(scene.objects().front()),
          [](const Vec3& p) { return sphere_distance(p, 0.09).distance; },
          figure_setup("sphere", kUnbounded, 0.0).hand.task, 16.0};
}

/// Returns the task `corner`: the hand presses with 3 N on each of the three walls of a corner, and
/// slides to and fro. In each period, it leaves and meets two of the walls, and keeps contact with
/// the third wall.
CompareTask corner() {
  HandTask hand;
  hand.path = HandPath::slide;
  hand.normal = Vec3(1.0, 1.0, 1.0);
  hand.along = Vec3(1.0, -1.0, 0.0);
  hand.depth = 0.01 * std::sqrt(3.0);
  hand.radius = 0.02;
  return {"corner",
          [](const Tool& tool) { return penalty(corner_distance(tool.position), kStiffness); },
          [](const Vec3& p) { return corner_distance(p).distance; },
          hand,
          8.0,
          corner_walls};
}

/// Returns the task `edge`: the hand slides over the edge of a box and back. It moves up one face,
/// over the edge with a force of 4 N, and onto the other face.
CompareTask edge() {
  Object box;
  box.name = "box";
  box.shape = Box{Vec3::Constant(0.1)};
  box.pose.position = {-0.1, -0.1, 0.0};
  box.material.stiffness = kStiffness;
  HandTask hand;
  hand.path = HandPath::slide;
  hand.normal = Vec3(1.0, 1.0, 0.0);
  hand.along = Vec3(1.0, -1.0, 0.0);
  hand.depth = 0.01;
  hand.radius = 0.02;
  return {"edge", environment(box), [](const Vec3& p) { return edge_distance(p).distance; }, hand,
          8.0};
}

/// Returns the task `torus`: the hand moves on a circle, as in the task `sphere`. The surface has a
/// bump of 1 mm every 23.6 mm, so the hand meets three bumps per second.
CompareTask torus() {
  const BumpyTorus shape;
  HandTask hand;
  hand.path = HandPath::orbit;
  hand.radius = shape.ring + shape.tube - 0.01;
  hand.depth = 0.0;
  hand.frequency = 0.125;
  hand.clearance = 0.02;
  return {"torus",
          [shape](const Tool& tool) {
            return penalty(torus_distance(shape, tool.position), kStiffness);
          },
          [shape](const Vec3& p) { return torus_distance(shape, p).distance; }, hand, 16.0};
}

Object flat() {
  Object plane;
  plane.name = "plane";
  plane.shape = Plane{};
  plane.material.stiffness = kStiffness;
  return plane;
}

/// Returns the task `stick_slip`: the hand presses on a plane with dry friction with 3 N, and
/// slides to and fro.
CompareTask stick_slip() {
  Object plane = flat();
  plane.material.static_friction = 0.6;
  plane.material.dynamic_friction = 0.3;
  HandTask hand;
  hand.path = HandPath::slide;
  return {"stick_slip", environment(plane),
          [](const Vec3& p) { return plane_distance(p).distance; }, hand, 8.0};
}

/// Returns the task `tap`: the hand hits a plane at 1 m/s, then presses with 3 N.
CompareTask tap() {
  HandTask hand;
  hand.path = HandPath::strike;
  hand.speed = 1.0;
  hand.lead_in = 0.3;
  hand.clearance = 0.1;
  return {"tap", environment(flat()), [](const Vec3& p) { return plane_distance(p).distance; },
          hand, 2.0};
}

}  // namespace

std::vector<CompareTask> compare_tasks() {
  return {wall(), sphere(), corner(), edge(), torus(), stick_slip(), tap()};
}

}  // namespace feltwire
