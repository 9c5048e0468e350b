#include <numbers>
#include <optional>
#include <utility>

#include "core/dynamics/mujoco_compile.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "sim/measure/glide.hpp"
#include "sim/studies/scene/trade_scene.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kMiddleBall = 1;  // index of the ball in base_objects()
constexpr double kMillimetre = 1e-3;    // [m]

std::vector<Object> base_objects() {
  Object floor, ball, block;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.pose.position = {0.0, 0.0, -0.2};
  ball.name = "ball";
  ball.shape = Sphere{kGlideBall};
  block.name = "block";
  block.shape = Box{Vec3(0.05, 0.1, 0.05)};
  block.pose.position = {0.3, 0.0, -0.15};
  std::vector<Object> objects = {floor, ball, block};
  for (Object& object : objects) object.material.stiffness = kGlideStiffness;
  return objects;
}

/// Returns a function that makes the base scene with a change to its ball.
template <class Change>
std::function<Scene()> ball(const Change& change) {
  return [change] {
    auto objects = base_objects();
    change(objects[kMiddleBall]);
    return Scene("base", std::move(objects));
  };
}

SceneCase mesh(std::string what, std::vector<std::string> needs, int level,
               const MeshOptions& options) {
  SceneCase c{std::move(what), std::move(needs), ball([level, options](Object& object) {
                object.shape = Mesh{std::make_shared<const MeshSurface>(
                    TriangleMesh(icosphere(kGlideBall, level)), options)};
              })};
  c.radius = options.radius;
  return c;
}

SceneCase guide(const std::string& what, GuidePlace place, const GuideAction& action,
                std::vector<std::string> needs = {"guides"}) {
  Guide made;
  made.name = what;
  made.place = std::move(place);
  made.action = action;
  made.max_force = 1.0;
  return {"guide: " + what, std::move(needs),
          [made] { return Scene("base", base_objects(), {}, {made}); }};
}

SceneCase held(std::string what, std::string need, double radius, std::size_t points) {
  SceneCase c{std::move(what), {std::move(need)}, [radius, points] {
                Scene scene("base", base_objects());
                HandTool tool;
                if (points == 0) {
                  tool.radius = radius;
                } else {
                  constexpr int kLevel = 4;
                  tool.body = std::make_shared<const BodyTool>(
                      point_shell(icosphere(radius, kLevel), points), ToolCoupling{}, 0.0);
                }
                scene.set_tool(std::move(tool));
                return scene;
              }};
  c.radius = radius;
  return c;
}

constexpr int kPebbleRow = 10;
constexpr double kPebblesApart = 0.1, kSmall = 0.02;  // [m] distance between the centres; radius

/// Returns a small ball outside the path of the hand. `i`: number of the ball.
Object pebble(std::size_t i) {
  const auto n = static_cast<int>(i);
  Object object;
  object.name = "pebble " + std::to_string(i);
  object.shape = Sphere{kSmall};
  const int row = n / kPebbleRow, layer = row / kPebbleRow;
  object.pose.position =
      kPebblesApart * Vec3(n % kPebbleRow, row % kPebbleRow, layer) + Vec3(-0.5, -0.5, 0.3);
  object.material.stiffness = kGlideStiffness;
  return object;
}

Shape mesh_pebble() {
  return Mesh{std::make_shared<const MeshSurface>(TriangleMesh(icosphere(kSmall, 3)))};
}

SceneCase many(std::size_t count, std::vector<std::string> needs) {
  return {std::to_string(count) + " objects", std::move(needs), [count] {
            auto objects = base_objects();
            while (objects.size() < count) objects.push_back(pebble(objects.size()));
            return Scene("base", std::move(objects));
          }};
}

/// Returns a case with moving bodies. The first body is the ball, which is too heavy to move. The
/// other bodies float beside it.
SceneCase moving(std::size_t count, const std::optional<Shape>& pebbles = {},
                 std::vector<std::string> needs = {"motion"}) {
  const std::string what =
      count == 1 ? "1 body" : std::to_string(count) + (pebbles ? " mesh bodies" : " bodies");
  return {what, std::move(needs), [count, pebbles] {
            constexpr double kStays = 1e6, kLight = 0.1;  // [kg] mass of the ball; of a pebble
            auto objects = base_objects();
            std::vector<int> body_of(objects.size(), -1);
            std::vector<Body> bodies(count);
            body_of[kMiddleBall] = 0;
            bodies[0].name = "ball";
            bodies[0].mass = kStays;
            for (std::size_t i = 1; i < count; ++i) {
              objects.push_back(pebble(i));
              if (pebbles) objects.back().shape = *pebbles;
              body_of.push_back(static_cast<int>(i));
              bodies[i].name = objects.back().name;
              bodies[i].pose = objects.back().pose;
              bodies[i].mass = kLight;
            }
            const auto mechanism = compile(objects, body_of, bodies, {.gravity = Vec3::Zero()});
            Scene scene("base", std::move(objects));
            scene.set_mechanism(mechanism);
            return scene;
          }};
}

SceneCase base() {
  return {"base: floor, ball, block", {}, [] { return Scene("base", base_objects()); }};
}

SceneCase clients(std::size_t count) {
  SceneCase c = base();
  c.what = std::to_string(count) + " clients";
  c.clients = count;
  return c;
}

}  // namespace

std::vector<SceneCase> scene_cases() {
  const Sphere region{2.0 * kGlideBall};
  std::vector<SceneCase> cases = {
      base(),
      {"dry friction", {"stick points"}, ball([](Object& o) {
         o.material.static_friction = 0.4;
         o.material.dynamic_friction = 0.3;
       })},
      {"damping", {"velocity"}, ball([](Object& o) { o.material.damping = 1.0; })},
      guide("attract to a line", GuideLine{}, Attract{.stiffness = 100.0}),
      guide("keep out of a ball", region, KeepOut{.stiffness = 100.0}),
      guide("magnet", GuidePoint{}, Magnet{.reach = 0.05}),
      guide("constant force", region, ConstantForce{.force = Vec3::UnitZ()}),
      guide("viscosity", region, Viscosity{.damping = 2.0}, {"guides", "velocity"}),
      mesh("mesh, 1280 triangles", {"triangles"}, 3, {}),
      mesh("mesh, 327680 triangles", {"triangles"}, 7, {}),
      mesh("mesh, 1280, smooth", {"triangles", "smooth normals"}, 3, {.smooth = true}),
      mesh("mesh, 1280, grain", {"triangles", "grain"}, 3,
           {.grain = {.amplitude = 1e-5, .wavelength = kMillimetre}}),
      mesh("mesh, 1280, ball of 1 mm", {"triangles", "triangles about a ball"}, 3,
           {.radius = kMillimetre}),
      {"grid of 1 mm", {"distance grids"}, ball([](Object& o) {
         o.shape = Grid{std::make_shared<const DistanceGrid<float>>(
             solid_of(Shape(Sphere{kGlideBall})), GridOptions{.resolution = kMillimetre})};
       })},
      held("tool: ball of 5 mm", "a ball in the hand", 5.0 * kMillimetre, 0),
      held("tool: ball of 1000 points", "a body in the hand", 10.0 * kMillimetre, 1000),
      held("tool: ball of 10000 points", "a body in the hand", 10.0 * kMillimetre, 10'000),
      moving(1),
      moving(10),
      moving(100),
      moving(1000),
      moving(100, mesh_pebble(), {"motion", "triangles"}),
      many(15, {}),
      many(16, {"a tree over the objects"}),
      many(1000, {"a tree over the objects"}),
      many(10'000, {"a tree over the objects"}),
      clients(10),
      clients(100)};
  SceneCase model = base();
  model.what = "client with a local model";
  model.local_model = true;
  cases.push_back(std::move(model));
  SceneCase observer = base();
  observer.what = "observer";
  observer.role = Role::observer;
  cases.push_back(std::move(observer));
  return cases;
}

}  // namespace feltwire
