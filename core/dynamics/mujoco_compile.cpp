#include "core/dynamics/mujoco_compile.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <set>
#include <stdexcept>

#include "core/base/numeric.hpp"
#include "core/base/written_number.hpp"
#include "core/dynamics/mass_properties.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/dynamics/mujoco_check.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/dynamics/mujoco_geoms.hpp"
#include "core/dynamics/mujoco_text.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

using mujoco::attribute;
using mujoco::place;
using mujoco::text;

/// Time constant of contacts between bodies, in ticks (MuJoCo's solref). The stability limit is 2.
constexpr double kContactTicks = 5.0;
/// MuJoCo's solimp of contacts and joint limits: the least and the largest impedance d, and the
/// depth [m] over which d grows. These soft constraints yield by the share 1 - d of the load. The
/// values are as rigid as possible without oscillation at the tick.
constexpr const char* kImpedance = "0.99 0.999 0.0001";

/// Largest number of bodies. MuJoCo's loader compares each body with each other body. Loading so
/// many bodies takes most of a minute.
constexpr std::size_t kMostBodies = 4000;

// The functions below write the model as MJCF. The bodies are named b0, b1, ...

Pose operator*(const Pose& a, const Pose& b) {
  return {a.position + a.orientation * b.position, a.orientation * b.orientation};
}
Pose inverse(const Pose& p) {
  const Quaternion back = p.orientation.conjugate();
  return {back * -p.position, back};
}

/// Returns a warning about an object without geoms: a hollow shape other than a box, or a shape
/// that MuJoCo lacks.
std::string passed_through(const Object& object) {
  return "object '" + object.name +
         "': hands feel it, but bodies pass through it: MuJoCo has no such solid; build what "
         "bodies rest on from closed meshes and solids felt from outside: " +
         names_of_primitives(false);
}

std::string joint_text(const Body& b) {
  if (b.joint == Joint::free) return "<freejoint/>\n";
  std::string out = "<joint" + attribute("type", b.joint == Joint::hinge ? "hinge" : "slide") +
                    attribute("axis", text(direction(b.axis))) +
                    attribute("stiffness", number_text(b.stiffness)) +
                    attribute("springref", number_text(b.rest)) +
                    attribute("damping", number_text(b.damping)) +
                    attribute("frictionloss", number_text(b.friction));
  if (mujoco::has_range(b))
    out += attribute("limited", "true") +
           attribute("range", number_text(std::max(b.low, -kLargestTravel)) + " " +
                                  number_text(std::min(b.high, kLargestTravel)));
  return out + "/>\n";
}

/// Indices of the objects of each body, in ascending order.
using ObjectsOfBodies = std::vector<std::vector<std::size_t>>;
ObjectsOfBodies objects_of(const std::vector<int>& body_of, std::size_t bodies) {
  ObjectsOfBodies all(bodies);
  for (std::size_t i = 0; i < body_of.size(); ++i)
    if (body_of[i] >= 0 && static_cast<std::size_t>(body_of[i]) < bodies)
      all[static_cast<std::size_t>(body_of[i])].push_back(i);
  return all;
}

/// Returns the mass properties of the body's objects, in the body's frame.
MassProperties solid_of(const Body& body, const std::vector<Object>& objects,
                        const std::vector<std::size_t>& own) {
  MassProperties all;
  for (const std::size_t i : own)
    all = together(all,
                   placed(mass_properties(objects[i].shape), inverse(body.pose) * objects[i].pose));
  return all;
}

std::string rounded(double value) { return printed("%.3g", value); }

/// Returns the <inertial> element with the exact mass and inertia of a solid. Without it, MuJoCo
/// would use the mass and inertia of the approximate geoms.
std::string inertial(const MassProperties& solid, double density) {
  const Mat3 inertia = density * solid.inertia;
  return "<inertial" + attribute("pos", text(solid.center)) +
         attribute("mass", number_text(density * solid.volume)) +
         attribute("fullinertia", text(inertia.diagonal()) + " " +
                                      text(Vec3(inertia(0, 1), inertia(0, 2), inertia(1, 2)))) +
         "/>\n";
}

/// Returns the error text for a mesh that has no volume and so cannot move.
Violation no_volume(const TriangleMesh& mesh) {
  const MeshReport& report = mesh.report();
  if (!report.closed())
    return {"mesh", "its surface is not closed (" + open_text(report) +
                        "), so it has no volume and cannot move; " + mend_text(report) +
                        ", or take it off its body"};
  return {"mesh", "its normals look inwards, so it has no volume and cannot move; turn them"};
}

/// Returns a warning about an angle above one turn, because the user may have meant degrees instead
/// of radians.
std::string odd_angle(const Body& body) {
  constexpr double kTurn = 2.0 * std::numbers::pi, kDegree = std::numbers::pi / 180.0;
  if (body.joint != Joint::hinge) return {};
  const auto warn = [&](const char* field, double angle) {
    return "body '" + body.name + "': " + field + ": " + number_text(angle) + " rad are " +
           rounded(angle / kTurn) + " turns; if it was meant in degrees, give " +
           rounded(angle * kDegree) + " rad";
  };
  for (const double end : {body.low, body.high})
    if (std::isfinite(end) && std::abs(end) > kTurn) return warn("range", end);
  return std::abs(body.rest) > kTurn ? warn("rest", body.rest) : "";
}

void check_bodies(const std::vector<Object>& objects, const std::vector<int>& body_of,
                  const ObjectsOfBodies& own_objects, const std::vector<Body>& bodies) {
  if (bodies.size() > kMostBodies)
    refuse("scene", {"bodies", "must be at most " + std::to_string(kMostBodies) +
                                   " that move, are " + std::to_string(bodies.size()) +
                                   "; have fewer, or fix those that need not move"});
  std::set<std::string> names;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::string whose = "body '" + bodies[i].name + "'";
    if (const auto broken = check(bodies[i])) refuse(whose, *broken);
    if (!names.insert(bodies[i].name).second)
      refuse(whose, {"name", "stands twice in the scene; rename one"});
    if (own_objects[i].empty())
      refuse(whose,
             {"objects", "it has none, so nothing of it can be felt; give an object \"body\": \"" +
                             bodies[i].name + "\" or remove the body"});
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (body_of[i] < 0) continue;
    const std::string whose = "object '" + objects[i].name + "'";
    if (objects[i].felt_from == Side::inside)
      refuse(whose, {"felt_from",
                     "a body is a solid and cannot be felt from inside; build the "
                     "hollow from several objects"});
    if (mass_properties(objects[i].shape).volume > 0.0) continue;
    if (const TriangleMesh* mesh = mujoco::triangles_of(objects[i].shape))
      refuse(whose, no_volume(*mesh));
    refuse(whose, {"body", "this shape has no volume and cannot move; use one of " +
                               names_of_primitives(true) + " or a closed mesh"});
  }
}

/// Adds a warning for each non-convex mesh for which no convex solids are given.
void warn_of_hulls(const std::vector<Object>& objects, const mujoco::CollisionGeoms& geoms,
                   const mujoco::ObjectSolids& solids, const std::vector<int>& body_of,
                   const std::vector<Body>& bodies, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const TriangleMesh* mesh = mujoco::triangles_of(objects[i].shape);
    if (mesh == nullptr || !geoms.has(i) || (!solids.empty() && solids[i] != nullptr)) continue;
    if (body_of[i] >= 0 && !bodies[static_cast<std::size_t>(body_of[i])].collides) continue;
    if (!is_convex(*mesh))
      warnings.push_back("object '" + objects[i].name +
                         "': hands feel the mesh, but bodies run into its convex hull; where that "
                         "matters build it from several convex objects");
  }
}

/// Refuses a body that is too small or too light for MuJoCo.
void check_inertia(const Body& body, const MassProperties& solid, double density) {
  const Eigen::SelfAdjointEigenSolver<Mat3> moments(density * solid.inertia,
                                                    Eigen::EigenvaluesOnly);
  const double least = moments.eigenvalues().minCoeff();
  if (least > mjMINVAL) return;
  refuse("body '" + body.name + "'",
         {body.mass ? "mass" : "density",
          "gives it an inertia of " + rounded(least) + " kg m^2, must be above " +
              rounded(mjMINVAL) + "; make it larger or heavier, or check the unit of its objects"});
}

std::string model_text(const std::vector<Object>& objects, const std::vector<int>& body_of,
                       const std::vector<Body>& bodies, const MechanismOptions& options,
                       const mujoco::ObjectSolids& solids, std::vector<std::string>& warnings) {
  const std::string solref = number_text(kContactTicks * options.tick) + " 1";
  const mujoco::CollisionGeoms geoms(objects, solids);
  warn_of_hulls(objects, geoms, solids, body_of, bodies, warnings);
  const std::string hulls = geoms.meshes();
  std::string xml = "<mujoco><compiler angle=\"radian\"/>\n<option" +
                    attribute("timestep", number_text(options.tick)) +
                    attribute("gravity", text(options.gravity)) +
                    // An elliptic friction cone with a higher stiffness and the noslip solver
                    // prevent the slow slip of soft constraints.
                    attribute("cone", "elliptic") + attribute("impratio", "10") +
                    attribute("noslip_iterations", "5") +
                    (bodies.size() > mujoco::kFewBodies ? attribute("solver", "CG") : "") + ">" +
                    // With multiccd, hulls rest flat on more than one point.
                    (hulls.empty() ? "" : "<flag multiccd=\"enable\"/>") + "</option>\n" +
                    mujoco::trial_room(geoms.count(), bodies) + "<default><geom" +
                    attribute("solref", solref) + attribute("solimp", kImpedance) + "/><joint" +
                    attribute("solreflimit", solref) + attribute("solimplimit", kImpedance) +
                    attribute("solreffriction", solref) + "/></default>\n<asset>\n";
  xml += hulls;
  xml += "</asset>\n<worldbody>\n";
  const ObjectsOfBodies own_objects = objects_of(body_of, bodies.size());
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (body_of[i] < 0) {
      xml += geoms.text(i, objects[i].pose, objects[i].material, "");
      if (!geoms.has(i)) warnings.push_back(passed_through(objects[i]));
    }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    xml += "<body" + attribute("name", "b" + std::to_string(b)) + place(body.pose) + ">" +
           joint_text(body);
    const std::vector<std::size_t>& own = own_objects[b];
    const MassProperties solid = solid_of(body, objects, own);
    const double density = body.mass ? *body.mass / solid.volume : *body.density;
    check_inertia(body, solid, density);
    if (!std::ranges::all_of(own, [&](std::size_t i) { return geoms.is_exact(i); }))
      xml += inertial(solid, density);
    std::string more = attribute("density", number_text(density));
    if (!body.collides) more += attribute("contype", "0") + attribute("conaffinity", "0");
    for (const std::size_t i : own)
      xml += geoms.text(i, inverse(body.pose) * objects[i].pose, objects[i].material, more);
    xml += "</body>\n";
  }
  return xml + "</worldbody></mujoco>\n";
}

/// Moves the objects without a body to the front. Otherwise keeps the order.
void put_still_first(std::vector<Object>& objects, std::vector<int>& body_of,
                     mujoco::ObjectSolids& solids) {
  std::vector<Object> ordered;
  std::vector<int> bodies;
  mujoco::ObjectSolids shapes;
  for (const bool moving : {false, true})
    for (std::size_t i = 0; i < objects.size(); ++i)
      if ((body_of[i] >= 0) == moving) {
        ordered.push_back(std::move(objects[i]));
        bodies.push_back(body_of[i]);
        if (!solids.empty()) shapes.push_back(std::move(solids[i]));
      }
  objects = std::move(ordered);
  body_of = std::move(bodies);
  solids = std::move(shapes);
}

}  // namespace

std::shared_ptr<const Mechanism> compile(std::vector<Object>& objects, std::vector<int> body_of,
                                         const std::vector<Body>& given,
                                         const MechanismOptions& options,
                                         std::vector<std::shared_ptr<const ConvexSolids>> solids) {
  if (body_of.size() != objects.size())
    throw std::invalid_argument("body_of: must have an entry for each object; give -1 for none");
  if (!solids.empty() && solids.size() != objects.size())
    throw std::invalid_argument("solids: must have an entry for each object; give null for none");
  if (const auto broken = check(options)) refuse("scene", *broken);
  for (Object& o : objects) {
    if (const auto broken = check(o.pose)) refuse("object '" + o.name + "'", *broken);
    o.pose.orientation.normalize();
  }
  std::vector<Body> bodies = given;
  check_bodies(objects, body_of, objects_of(body_of, bodies.size()), bodies);
  for (Body& b : bodies) b.pose.orientation.normalize();
  put_still_first(objects, body_of, solids);

  std::vector<std::string> warnings;
  for (const Body& body : bodies)
    if (std::string odd = odd_angle(body); !odd.empty()) warnings.push_back(std::move(odd));
  mujoco::Loaded loaded =
      mujoco::load_text(model_text(objects, body_of, bodies, options, solids, warnings));
  if (loaded.model == nullptr)
    throw std::invalid_argument("bodies: MuJoCo refuses them: " + loaded.error +
                                (loaded.error.find("memory") == std::string::npos
                                     ? "; check masses, sizes and places"
                                     : ""));
  loaded.model->nconmax = 0;  // With 0, the simulation may enlarge its buffers.
  std::vector<Mechanism::Part> parts;
  std::size_t still = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (body_of[i] < 0) {
      ++still;
      continue;
    }
    const auto b = static_cast<std::size_t>(body_of[i]);
    const std::string name = "b" + std::to_string(b);
    parts.push_back({mj_name2id(loaded.model.get(), mjOBJ_BODY, name.c_str()),
                     inverse(bodies[b].pose) * objects[i].pose});
  }
  for (std::string& warning : mujoco::warnings_of(
           *loaded.model, {}, objects, mujoco::objects_of_geoms(*loaded.model), still, parts))
    warnings.push_back(std::move(warning));
  return std::make_shared<Mechanism>(
      std::shared_ptr<const mjModel>(loaded.model.release(), mujoco::DeleteModel{}), still,
      std::move(parts), std::move(warnings));
}

}  // namespace feltwire
