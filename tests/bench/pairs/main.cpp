// feltwire-pairbench measures the penetration depth of two convex polyhedra with libraries of
// Debian 12, and the time of their queries and of our add_depth() (docs/lab/trade.md has a table).
// - libccd's EPA compares its tolerance with a squared length, and the default is 1e-4.
// - Bullet adds a margin of 0.04 to each shape by default.
// - FCL's collide() measures convex shapes by libccd's MPR (GST_LIBCCD), or by its own EPA with the
//   other sign (GST_INDEP). distance() uses another EPA.
// - FCL, ODE and MuJoCo give several points for two boxes. The deepest point counts.
// A query also moves the tool. For MuJoCo the time includes mj_kinematics() and mj_collision()
// completely.

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <ccd/ccd.h>
#include <fcl/fcl.h>
#include <mujoco/mujoco.h>
#include <ode/ode.h>
#include <ode/version.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/splitmix.hpp"
#include "core/base/text.hpp"
#include "core/build_info/build_info.hpp"
#include "core/polyhedra/depth_integrals.hpp"
#include "sim/measure/cost.hpp"

namespace feltwire {
namespace {

constexpr double kNone = NAN;                            // depth without contact
const Vec3 kAway = Vec3(0.48, 0.60, 0.64).normalized();  // direction from the solid to the tool

/// The tool's pose in the solid's frame, and its depth.
struct Place {
  Quaternion orientation = Quaternion::Identity();
  Mat3 rotation = Mat3::Identity();
  Vec3 position = Vec3::Zero();
  double depth = 0.0;
  // unit vector; moving the tool by the depth along it ends the contact
  Vec3 normal = Vec3::Zero();
};

/// A pair with its own unit of length: `metre` units are one metre.
struct Pair {
  double metre;
  Polyhedron tool, solid;
  std::vector<Place> places;
};

using Query = std::function<double(const Place&)>;  // the depth at a place, or kNone

/// Returns the hull of points on an ellipsoid. Each point is a corner. With 0 corners it returns a
/// box.
Polyhedron random_solid(std::uint64_t corners, double metre, std::uint64_t seed) {
  std::vector<Vec3> points;
  for (std::uint64_t i = 0; i < corners; ++i) {
    const auto uniform = [&](std::uint64_t draw) {
      return 0x1p-53 * static_cast<double>(splitmix::draw(seed, 2 * i + draw) >> 11);
    };
    const double z = 2.0 * uniform(0) - 1.0, angle = 2.0 * std::numbers::pi * uniform(1);
    const double r = std::sqrt(1.0 - z * z);
    points.emplace_back(0.011 * r * std::cos(angle), 0.010 * r * std::sin(angle), 0.009 * z);
  }
  for (int i = 0; i < 8 && corners == 0; ++i)
    points.emplace_back(i & 1 ? 0.01 : -0.01, i & 2 ? 0.01 : -0.01, i & 4 ? 0.02 : -0.02);
  for (Vec3& p : points) p *= metre;
  return polyhedron(points);
}

double reach(const Polyhedron& of, const Vec3& direction) {
  double most = -HUGE_VAL;
  for (const Vec3& v : of.vertices) most = std::max(most, direction.dot(v));
  return most;
}

/// Returns the faces of the Minkowski difference of `solid` and `tool`, with `tool` rotated and at
/// the origin. Each face of both polyhedra gives a face. Each pair of edges with crossing arcs on
/// the sphere of normals gives another face (Gregorius 2013, The separating axis test). The depth
/// is the tool's least height below a face.
std::vector<HalfSpaceBelow> separating_planes(const Polyhedron& solid, const Polyhedron& tool) {
  std::vector<HalfSpaceBelow> planes;
  for (const auto& [n, offset] : solid.planes) planes.push_back({n, offset + reach(tool, -n)});
  for (const auto& [n, offset] : tool.planes) planes.push_back({-n, offset + reach(solid, -n)});
  for (const PolyhedronEdge& e : solid.edges) {
    const Vec3 &from = solid.vertices[e.from], along = solid.vertices[e.to] - from;
    const Vec3 &left = solid.planes[e.left].normal, &right = solid.planes[e.right].normal;
    for (const PolyhedronEdge& t : tool.edges) {
      const Vec3 &t_from = tool.vertices[t.from], t_along = tool.vertices[t.to] - t_from;
      const Vec3 &t_left = tool.planes[t.left].normal, &t_right = tool.planes[t.right].normal;
      if (t_left.dot(along) * t_right.dot(along) >= 0.0) continue;
      if (left.dot(t_along) * right.dot(t_along) >= 0.0) continue;
      Vec3 normal = along.cross(t_along).normalized();
      if (normal.dot(left + right) < 0.0) normal = -normal;
      if (normal.dot(t_left + t_right) >= 0.0) continue;  // The arcs are on opposite sides.
      planes.push_back({normal, normal.dot(from - t_from)});
    }
  }
  return planes;
}

/// `corners`: 0 for boxes. The tool rotates once about a moving axis. At each position the tool
/// moves along kAway to the required depth.
Pair pair_of(std::uint64_t corners, double metre) {
  constexpr int kPlaces = 4000;
  Pair pair{metre, random_solid(corners, metre, 1), random_solid(corners, metre, 2), {}};
  for (int i = 0; i < kPlaces; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kPlaces;
    const Vec3 axis(std::cos(0.7 * turn), std::sin(0.9 * turn + 0.4), 0.8);
    const Quaternion orientation(Eigen::AngleAxisd(turn + 0.3, axis.normalized()));
    const Mat3 rotation = orientation.toRotationMatrix();
    Polyhedron turned = pair.tool;
    for (Vec3& v : turned.vertices) v = rotation * v;
    for (HalfSpaceBelow& face : turned.planes) face.normal = rotation * face.normal;
    const auto planes = separating_planes(pair.solid, turned);
    const double depth = metre * (1.5e-3 + 1e-3 * std::sin(3.0 * turn));
    double far = HUGE_VAL;
    for (const auto& [n, offset] : planes)
      if (n.dot(kAway) > 0.0) far = std::min(far, (offset - depth) / n.dot(kAway));
    const Vec3 position = far * kAway;
    const auto below = [&](const HalfSpaceBelow& p) { return p.offset - p.normal.dot(position); };
    const HalfSpaceBelow& nearest = *std::ranges::min_element(planes, {}, below);
    pair.places.push_back({orientation, rotation, position, below(nearest), nearest.normal});
  }
  return pair;
}

struct CcdSolid {
  const Polyhedron& shape;
  const Place& place;
};

void ccd_support(const void* of, const ccd_vec3_t* direction, ccd_vec3_t* found) {
  const auto& [shape, place] = *static_cast<const CcdSolid*>(of);
  const Vec3 own = place.rotation.transpose() * Eigen::Map<const Vec3>(direction->v);
  const Vec3* best = shape.vertices.data();
  double most = -HUGE_VAL;
  for (const Vec3& v : shape.vertices)
    if (const double along = own.dot(v); along > most) most = along, best = &v;
  Eigen::Map<Vec3>(found->v) = place.rotation * *best + place.position;
}

void ccd_middle(const void* of, ccd_vec3_t* found) {
  Eigen::Map<Vec3>(found->v) = static_cast<const CcdSolid*>(of)->place.position;
}

Query libccd(const Pair& pair, decltype(&ccdGJKPenetration) penetration) {
  ccd_t settings;
  CCD_INIT(&settings);
  settings.support1 = settings.support2 = ccd_support;
  settings.center1 = settings.center2 = ccd_middle;
  settings.mpr_tolerance = 1e-9 * pair.metre;
  settings.epa_tolerance = 1e-14 * pair.metre * pair.metre;
  return [=, &pair, here = Place()](const Place& place) {
    const CcdSolid tool{pair.tool, place}, solid{pair.solid, here};
    double depth = 0.0;
    ccd_vec3_t direction, position;
    const int status = penetration(&solid, &tool, &settings, &depth, &direction, &position);
    return status == 0 ? depth : kNone;
  };
}

btVector3 bullet_vector(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

std::shared_ptr<btConvexHullShape> bullet_hull(const Polyhedron& of) {
  auto shape = std::make_shared<btConvexHullShape>();
  for (const Vec3& v : of.vertices) shape->addPoint(bullet_vector(v));
  shape->setMargin(0);
  return shape;
}

Query bullet(const Pair& pair) {
  return [tool = bullet_hull(pair.tool), solid = bullet_hull(pair.solid)](const Place& place) {
    const auto q = place.orientation.cast<btScalar>();
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA.setIdentity();
    input.m_transformB.setRotation(btQuaternion(q.x(), q.y(), q.z(), q.w()));
    input.m_transformB.setOrigin(bullet_vector(place.position));
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver epa;
    btGjkPairDetector detector(solid.get(), tool.get(), &simplex, &epa);
    btPointCollector found;
    detector.getClosestPoints(input, found, nullptr);
    return found.m_distance < 0 ? -double{found.m_distance} : kNone;
  };
}

/// Returns the number of corners and the corners of each face.
template <class Index>
std::vector<Index> faces(const Polyhedron& of) {
  std::vector<Index> all;
  for (std::size_t f = 0; f < of.planes.size(); ++f) {
    all.push_back(static_cast<Index>(of.face(f).size()));
    all.insert(all.end(), of.face(f).begin(), of.face(f).end());
  }
  return all;
}

using FclShape = std::shared_ptr<fcl::CollisionGeometryd>;

FclShape fcl_convex(const Polyhedron& of) {
  return std::make_shared<fcl::Convexd>(std::make_shared<std::vector<Vec3>>(of.vertices),
                                        static_cast<int>(of.planes.size()),
                                        std::make_shared<std::vector<int>>(faces<int>(of)), true);
}

const fcl::Transform3d kHere = fcl::Transform3d::Identity();

Query fcl_collide(const FclShape& tool, const FclShape& solid, fcl::GJKSolverType solver) {
  fcl::CollisionRequestd request(8, true);
  request.gjk_solver_type = solver;
  return [=](const Place& place) {
    const fcl::Transform3d at(fcl::Translation3d(place.position) * place.orientation);
    fcl::CollisionResultd found;
    fcl::collide(solid.get(), kHere, tool.get(), at, request, found);
    double depth = kNone;
    for (std::size_t i = 0; i < found.numContacts(); ++i)
      depth = std::fmax(depth, std::abs(found.getContact(i).penetration_depth));
    return depth;
  };
}

Query fcl_distance(const FclShape& tool, const FclShape& solid) {
  return [=, request = fcl::DistanceRequestd(false, true)](const Place& place) {
    const fcl::Transform3d at(fcl::Translation3d(place.position) * place.orientation);
    fcl::DistanceResultd found;
    const double gap = fcl::distance(solid.get(), kHere, tool.get(), at, request, found);
    return gap < 0.0 ? -gap : kNone;
  };
}

/// The geom keeps pointers to the numbers, including those of `of`.
dGeomID ode_convex(const Polyhedron& of) {
  static std::vector<std::vector<unsigned>> polygons;
  polygons.push_back(faces<unsigned>(of));
  static_assert(sizeof(HalfSpaceBelow) == 4 * sizeof(dReal));
  return dCreateConvex(nullptr, of.planes[0].normal.data(), static_cast<unsigned>(of.planes.size()),
                       of.vertices[0].data(), static_cast<unsigned>(of.vertices.size()),
                       polygons.back().data());
}

Query ode(dGeomID tool, dGeomID solid) {
  return [=](const Place& place) {
    const Vec3& p = place.position;
    const Quaternion& q = place.orientation;
    const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
    dGeomSetPosition(tool, p.x(), p.y(), p.z());
    dGeomSetQuaternion(tool, turn);
    dContactGeom found[8];
    const int count = dCollide(solid, tool, 8, found, sizeof(dContactGeom));
    double depth = kNone;
    for (int i = 0; i < count; ++i) depth = std::fmax(depth, found[i].depth);
    return depth;
  };
}

/// The file gives no margin, so each geom has the margin 0.
Query mujoco(const Pair& pair, bool as_boxes) {
  std::string meshes, geoms[2];
  for (const int i : {0, 1}) {
    const Polyhedron& of = i == 0 ? pair.solid : pair.tool;
    append(meshes, "<mesh name=\"%d\" vertex=\"", i);
    for (const Vec3& v : of.vertices) append(meshes, "%.17g %.17g %.17g ", v.x(), v.y(), v.z());
    meshes += "\"/>";
    if (!as_boxes) append(geoms[i], "<geom type=\"mesh\" mesh=\"%d\"/>", i);
    if (as_boxes)
      append(geoms[i], "<geom type=\"box\" size=\"%.17g %.17g %.17g\"/>", of.most.x(), of.most.y(),
             of.most.z());
  }
  const std::string text =
      "<mujoco><compiler coordinate=\"local\"/><asset>" + meshes + "</asset><worldbody>" +
      geoms[0] + "<body><freejoint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>" +
      geoms[1] + "</body></worldbody></mujoco>";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "pair", static_cast<int>(text.size()));
  std::ranges::copy(text, static_cast<char*>(files->filedata[0]));
  char why[1000] = {};
  const std::shared_ptr<mjModel> model(mj_loadXML("pair", files.get(), why, 1000), mj_deleteModel);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + why);
  const std::shared_ptr<mjData> data(mj_makeData(model.get()), mj_deleteData);
  return [=](const Place& place) {
    const Quaternion& q = place.orientation;
    Eigen::Map<Eigen::Vector<double, 7>>(data->qpos) << place.position, q.w(), q.x(), q.y(), q.z();
    mj_kinematics(model.get(), data.get());
    mj_collision(model.get(), data.get());
    double depth = kNone;
    for (int i = 0; i < data->ncon; ++i) depth = std::fmax(depth, -data->contact[i].dist);
    return depth;
  };
}

double nanoseconds(const Pair& pair, const Query& query) {
  const auto at = [&](std::size_t i) { query(pair.places[i]); };
  return cost_ns(pair.places.size(), at, 5);
}

void print_library(const Pair& pair, const std::string& name, const Query& query) {
  double squares = 0.0, error = 0.0, jump = 0.0, before = kNone;
  std::size_t none = 0;
  for (const Place& place : pair.places) {
    const double depth = query(place), off = std::abs(depth - place.depth);
    none += std::isnan(depth) ? 1 : 0;
    squares += std::isnan(depth) ? 0.0 : off * off;
    error = std::fmax(error, off);
    jump = std::fmax(jump, std::abs(depth - before));
    before = depth;
  }
  const double mm = 1e3 / pair.metre, found = static_cast<double>(pair.places.size() - none);
  std::printf("%-19s %7.0f %9.4f %9.4f %9.4f %10zu\n", name.c_str(), nanoseconds(pair, query),
              mm * std::sqrt(squares / found), mm * error, mm * jump, none);
}

/// Results that do not depend on the unit are measured in metres only.
void print_libraries(const Pair& pair, const std::string& unit, bool boxes) {
  const FclShape tool = fcl_convex(pair.tool), solid = fcl_convex(pair.solid);
  if (unit == "m" && boxes) {
    const Vec3 sides = 2.0 * pair.solid.most;
    const FclShape box = std::make_shared<fcl::Boxd>(sides);
    const auto geom = [&] { return dCreateBox(nullptr, sides.x(), sides.y(), sides.z()); };
    print_library(pair, "FCL, Box", fcl_collide(box, box, fcl::GST_LIBCCD));
    print_library(pair, "ODE, box", ode(geom(), geom()));
    print_library(pair, "MuJoCo, box", mujoco(pair, true));
  }
  if (unit == "m") {
    print_library(pair, "libccd MPR", libccd(pair, ccdMPRPenetration));
    print_library(pair, "FCL, GST_LIBCCD", fcl_collide(tool, solid, fcl::GST_LIBCCD));
    print_library(pair, "ODE, convex", ode(ode_convex(pair.tool), ode_convex(pair.solid)));
    print_library(pair, "MuJoCo, mesh", mujoco(pair, false));
  }
  print_library(pair, "FCL, GST_INDEP, " + unit, fcl_collide(tool, solid, fcl::GST_INDEP));
  print_library(pair, "libccd GJK, EPA, " + unit, libccd(pair, ccdGJKPenetration));
  print_library(pair, "Bullet GJK, EPA, " + unit, bullet(pair));
  print_library(pair, "FCL distance(), " + unit, fcl_distance(tool, solid));
}

/// Calls add_depth() as a polygonal tool does, in metres: the solid is thickened away from the
/// tool. Then prints the largest change of the force between positions, and the largest change of
/// the true depth times its normal.
void print_own(const Pair& pair) {
  const SolidPart solid = solid_parts({pair.solid.vertices}).parts[0];
  const auto sums_at = [&](const Place& at) {
    DepthSums sums;
    add_depth({pair.tool, at.rotation, at.position}, solid, false, &kAway, false, sums);
    return sums;
  };
  Vec3 before[2] = {Vec3::Constant(kNone), Vec3::Constant(kNone)};
  double most[2] = {}, jump[2] = {};
  for (const Place& at : pair.places) {
    const DepthSums sums = sums_at(at);
    const Vec3 now[2] = {sums.slope.head<3>() / std::sqrt(sums.cubes), at.depth * at.normal};
    for (const int i : {0, 1}) {
      most[i] = std::max(most[i], now[i].norm());
      jump[i] = std::fmax(jump[i], (now[i] - before[i]).norm());
      before[i] = now[i];
    }
  }
  std::printf("%-19s %7.0f   change of force: %.2f %%; of true depth times normal: %.2f %%\n",
              "own add_depth()",
              nanoseconds(pair, [&](const Place& at) { return sums_at(at).cubes; }),
              1e2 * jump[0] / most[0], 1e2 * jump[1] / most[1]);
}

}  // namespace
}  // namespace feltwire

int main(int argc, char** argv) try {
  using namespace feltwire;
  CLI::App app("Convex pairs by libraries and by us (docs/lab/trade.md).", "feltwire-pairbench");
  app.set_version_flag("--version", [] { return build_info("feltwire-pairbench"); });
  CLI11_PARSE(app, argc, argv);
  dInitODE2(0);
  std::printf("libccd %s, Bullet %.2f (%zu bits, margin 0), FCL %s, ODE %s, MuJoCo %s\n",
              FELTWIRE_CCD_VERSION, 0.01 * BT_BULLET_VERSION, 8 * sizeof(btScalar), FCL_VERSION,
              dODE_VERSION, mj_versionString());
  for (const std::uint64_t corners : {0, 16, 100}) {
    const Pair metres = pair_of(corners, 1.0), millimetres = pair_of(corners, 1000.0);
    const std::string name = corners == 0 ? "boxes" : "hulls of " + std::to_string(corners);
    std::printf("\n%-19s %7s %9s %9s %9s %10s\n", name.c_str(), "ns", "rms [mm]", "most [mm]",
                "jump [mm]", "no contact");
    print_libraries(metres, "m", corners == 0);
    print_libraries(millimetres, "mm", corners == 0);
    print_own(metres);
  }
  dCloseODE();
} catch (const std::exception& e) {
  std::fprintf(stderr, "feltwire-pairbench: %s\n", e.what());
  return 1;
}
