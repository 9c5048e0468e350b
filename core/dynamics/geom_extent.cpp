#include "core/dynamics/geom_extent.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/dynamics/mujoco_error_trap.hpp"

namespace feltwire::mujoco {
namespace {

/// Returns half the extent [m] of a geom along a direction in the geom's frame.
double half_extent(const mjModel& model, int geom, const Vec3& own) {
  const Vec3 size = vector(entry<3>(model.geom_size, geom));
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return size.x();
    case mjGEOM_CAPSULE:
      return size.x() + size.y() * std::abs(own.z());
    case mjGEOM_CYLINDER:
      return size.x() * std::hypot(own.x(), own.y()) + size.y() * std::abs(own.z());
    case mjGEOM_ELLIPSOID:
      return own.cwiseProduct(size).norm();
    case mjGEOM_BOX:
      return own.cwiseAbs().dot(size);
    case mjGEOM_MESH: {
      const int mesh = model.geom_dataid[geom];
      const float* v = model.mesh_vert + std::ptrdiff_t{3} * model.mesh_vertadr[mesh];
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (int i = 0; i < model.mesh_vertnum[mesh]; ++i, v += 3) {
        const double at = own.dot(Vec3(v[0], v[1], v[2]));
        low = std::min(low, at);
        high = std::max(high, at);
      }
      return 0.5 * (high - low);
    }
    default:
      return model.geom_rbound[geom];
  }
}

}  // namespace

double half_extent_along(const mjModel& model, const mjData& data, int geom, const Vec3& along) {
  const mjtNum* const turn = entry<9>(data.geom_xmat, geom);
  const Vec3 own(turn[0] * along.x() + turn[3] * along.y() + turn[6] * along.z(),
                 turn[1] * along.x() + turn[4] * along.y() + turn[7] * along.z(),
                 turn[2] * along.x() + turn[5] * along.y() + turn[8] * along.z());
  return half_extent(model, geom, own);
}

double half_thickness(const mjModel& model, int geom) {
  return std::min({half_extent(model, geom, Vec3::UnitX()), half_extent(model, geom, Vec3::UnitY()),
                   half_extent(model, geom, Vec3::UnitZ())});
}

bool falls(const mjModel& model, const mjData& data, int body, const Vec3& up) {
  constexpr double kAlong = 0.1;
  for (; body != 0; body = model.body_parentid[body])
    for (int j = 0; j < model.body_jntnum[body]; ++j) {
      const int joint = model.body_jntadr[body] + j;
      if (model.jnt_type[joint] == mjJNT_FREE) return true;
      if (model.jnt_type[joint] == mjJNT_SLIDE &&
          std::abs(vector(entry<3>(data.xaxis, joint)).dot(up)) > kAlong)
        return true;
    }
  return false;
}

bool meet(const mjModel& model, int a, int b) {
  if (model.geom_bodyid[a] == model.geom_bodyid[b]) return false;
  return (model.geom_contype[a] & model.geom_conaffinity[b]) != 0 ||
         (model.geom_contype[b] & model.geom_conaffinity[a]) != 0;
}

bool overlap(const mjModel& model, const mjData& data, int a, int b, const Vec3& up) {
  const Vec3 apart = vector(entry<3>(data.geom_xpos, a)) - vector(entry<3>(data.geom_xpos, b));
  return (apart - up.dot(apart) * up).norm() <= model.geom_rbound[a] + model.geom_rbound[b];
}

double contact_time(const mjModel& model, int a, int b) {
  const auto of = [&](int geom) { return model.geom_solref[std::ptrdiff_t{mjNREF} * geom]; };
  const double shortest = 2.0 * model.opt.timestep;  // MuJoCo's shortest time constant
  return std::max({of(a), of(b), shortest});
}

}  // namespace feltwire::mujoco
