#include "core/dynamics/mujoco_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/base/written_number.hpp"
#include "core/dynamics/heavy_loads.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/dynamics/thin_contacts.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire::mujoco {
namespace {

// [m] deeper overlaps at the start are reported; a resting contact is never so deep.
constexpr double kOverlap = 1e-4;
/// Largest accepted value of tick * sqrt(k / m), for a contact stiffness k and a mass m. A single
/// undamped spring is stable up to 2 under symplectic Euler. However, n hands at one point act as
/// one spring of stiffness n k.
constexpr double kCalm = 1.0;

/// Returns half the side lengths [m] of the bounding box of a shape.
Vec3 half_extents(const Shape& shape) {
  if (const auto* m = std::get_if<Mesh>(&shape)) return m->surface->mesh().half_extents();
  return on_primitive(
      shape,
      [](const auto& solid) { return is_bounded(solid) ? solid.half_box() : Vec3(Vec3::Zero()); },
      [] { return Vec3(Vec3::Zero()); });
}

/// Returns true if the shape lies inside the largest ball in its bounding box.
bool is_ball(const Shape& shape) {
  return on_primitive(
      shape, [](const auto& solid) { return solid.reach() <= solid.half_box().minCoeff(); },
      [] { return false; });
}

/// Returns the centre of the bounding box [m, object frame].
Vec3 middle(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr ? mesh->surface->mesh().origin() : Vec3::Zero();
}

using Wrench = Eigen::Matrix<double, 6, 1>;
using Mobility = Eigen::Matrix<double, 6, 6>;

/// Returns the matrix that maps an impulse on the body at its origin to the linear and angular
/// velocity after it.
Mobility mobility(const mjModel& model, mjData& data, int body) {
  constexpr int kLinear = 3, kWays = 6;
  Eigen::Matrix<double, kWays, Eigen::Dynamic, Eigen::RowMajor> jacobian(kWays, model.nv);
  mj_jacBody(&model, &data, jacobian.data(), jacobian.row(kLinear).data(), body);
  auto answer = jacobian;
  mj_solveM(&model, &data, answer.data(), jacobian.data(), kWays);
  return jacobian * answer.transpose();
}

/// Returns the inverse effective mass [1/kg] along `normal`, at the offset `arm` [m] from the
/// body's origin.
double yielding(const Mobility& moves, const Vec3& arm, const Vec3& normal) {
  Wrench wrench;
  wrench << normal, arm.cross(normal);
  return wrench.dot(moves * wrench);
}

/// Returns the largest inverse effective mass [1/kg] over the middles of faces and edges and over
/// the corners of the object's bounding box.
double most_yielding(const mjModel& model, mjData& data, const Object& object, int body) {
  double most = 0.0;
  const Mobility moves = mobility(model, data, body);
  const Vec3 origin = vector(entry<3>(data.xpos, body));
  const Vec3 h = half_extents(object.shape);
  const bool ball = is_ball(object.shape);
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        // Skip the box's corners and edges for a ball, because they lie outside the ball.
        if (ball && std::abs(x) + std::abs(y) + std::abs(z) > 1) continue;
        const Vec3 own = middle(object.shape) + h.cwiseProduct(Vec3(x, y, z));
        const Vec3 point = object.pose.position + object.pose.orientation * own;
        for (int axis = 0; axis < 3; ++axis)
          if (Vec3(x, y, z)[axis] != 0.0)
            most = std::max(
                most, yielding(moves, point - origin, object.pose.orientation * Vec3::Unit(axis)));
      }
  return most;
}

std::string too_light(const Object& object, double mass, double tick) {
  const double stiffness = object.material.stiffness;
  const double calm_tick = kCalm * std::sqrt(mass / stiffness);  // [s] longest accepted tick
  return "object '" + object.name + "': " + printed("%.3g g", 1e3 * mass) +
         " where it yields most, against a material of " + printed("%.4g N/m", stiffness) +
         ", swings faster than a tick of " + printed("%.3g ms", 1e3 * tick) +
         " follows; what keeps it calm is a stiffness of at most " +
         printed("%.3g N/m", kCalm * kCalm * mass / (tick * tick)) + ", or at least " +
         printed("%.3g g", 1e3 * stiffness * tick * tick / (kCalm * kCalm)) + " there" +
         (calm_tick >= kLeastTick ? ", or a tick of at most " + printed("%.3g s", calm_tick)
                                  : "; no tick that a scene may have is short enough");
}

/// Returns the body to which the index in a MuJoCo warning belongs, or a negative number if it is
/// unknown.
int body_of(const mjModel& model, int kind, int index) {
  if (kind != mjWARN_BADQPOS) return index >= 0 && index < model.nv ? model.dof_bodyid[index] : -1;
  int body = -1;
  for (int joint = 0; joint < model.njnt; ++joint)
    if (model.jnt_qposadr[joint] <= index) body = model.jnt_bodyid[joint];
  return body;
}

/// Returns a name for messages: the object of this body, or else the name of the body itself.
std::string name_of(const mjModel& model, int body, const std::vector<Object>& objects,
                    std::size_t still, const std::vector<Mechanism::Part>& parts) {
  const auto part = std::ranges::find(parts, body, &Mechanism::Part::body);
  if (part != parts.end())
    return "object '" + objects[still + static_cast<std::size_t>(part - parts.begin())].name + "'";
  const char* name = body < 0 ? nullptr : mj_id2name(&model, mjOBJ_BODY, body);
  return name != nullptr && *name != '\0' ? "body '" + std::string(name) + "'" : "a body";
}

struct BadStep {
  int kind;  // type of MuJoCo's warning
  const char* what;
};
constexpr std::array<BadStep, 3> kBadSteps = {
    {{mjWARN_BADQACC, "acceleration"}, {mjWARN_BADQVEL, "speed"}, {mjWARN_BADQPOS, "place"}}};

/// Simulates the first steps. Returns a warning if a step fails. After a failed step, MuJoCo resets
/// its state. Then the world resets at every step, and nothing moves.
template <class Name>
std::optional<std::string> first_steps(Simulation& simulation, Name name) {
  constexpr int kSteps = 3;
  for (int step = 1; step <= kSteps; ++step) {
    const bool done = simulation.advance() && simulation.evaluate();
    const std::string breaks = "the simulation breaks at its step " + std::to_string(step) + ": ";
    for (const BadStep& bad : kBadSteps)
      if (const mjWarningStat& warned = simulation.data()->warning[bad.kind]; warned.number > 0)
        return breaks + "MuJoCo finds an impossible " + bad.what + " of " +
               name(body_of(simulation.model(), bad.kind, warned.lastinfo)) +
               " and puts everything back, so that nothing moves; give that more mass or inertia, "
               "softer springs and weaker actuators, or the scene a shorter tick";
    if (!done) return breaks + "MuJoCo cannot do it; have fewer bodies, or bodies that touch less";
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> warnings_of(const mjModel& model, const std::vector<mjtNum>& start,
                                     const std::vector<Object>& objects,
                                     const std::vector<int>& object_of, std::size_t still,
                                     const std::vector<Mechanism::Part>& parts) {
  std::optional<Simulation> simulation;
  try {
    simulation.emplace(model, kMostMemory, start);
  } catch (const std::runtime_error& error) {
    return {error.what()};
  }
  mjData* const data = simulation->data();
  std::vector<std::string> warnings;
  if (simulation->is_full())
    warnings.emplace_back(
        "the bodies begin in more contacts than there is memory for, and pass through each other; "
        "move them apart, or have fewer");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Object& object = objects[still + i];
    const double inverse = most_yielding(model, *data, object, parts[i].body);
    if (model.opt.timestep * std::sqrt(object.material.stiffness * inverse) > kCalm)
      warnings.push_back(too_light(object, 1.0 / inverse, model.opt.timestep));
  }
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    const int a = object_of[static_cast<std::size_t>(contact.geom1)];
    const int b = object_of[static_cast<std::size_t>(contact.geom2)];
    if (!(contact.dist < -kOverlap) || a < 0 || b < 0) continue;
    const std::string line =
        "objects '" + objects[static_cast<std::size_t>(a)].name + "' and '" +
        objects[static_cast<std::size_t>(b)].name + "' begin " +
        printed("%.2g mm", -1e3 * contact.dist) +
        " inside each other and are thrown apart; move one, or let its body not collide";
    const std::string pair = line.substr(0, line.find(" begin "));
    const bool said = std::any_of(warnings.begin(), warnings.end(), [&](const std::string& w) {
      return w.compare(0, pair.size(), pair) == 0;
    });
    if (!said) warnings.push_back(line);
  }
  for (std::string& thin : thin_contacts(model, *data, objects, object_of))
    warnings.push_back(std::move(thin));
  if (std::string pushed = thin_pushed_bodies(model, objects, object_of); !pushed.empty())
    warnings.push_back(std::move(pushed));
  for (std::string& heavy : heavy_loads(model, *data, objects, object_of))
    warnings.push_back(std::move(heavy));
  // Simulate the steps last, because they move the bodies.
  if (auto broken = first_steps(
          *simulation, [&](int body) { return name_of(model, body, objects, still, parts); }))
    warnings.push_back(*std::move(broken));
  return warnings;
}

}  // namespace feltwire::mujoco
