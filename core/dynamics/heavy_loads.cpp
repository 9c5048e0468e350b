#include "core/dynamics/heavy_loads.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/written_number.hpp"
#include "core/dynamics/geom_extent.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {
namespace {

// Largest yield that is not reported, as a share of the light body's height.
constexpr double kNotableYield = 0.05;

/// A geom of a body that gravity moves.
struct LoadedGeom {
  int geom;
  double low, high;  // [m] lowest and highest point along `up`
  double mass;       // [kg] of its body
};

/// The least impedance of the contact between two geoms: a contact has it when it begins.
double impedance_of(const mjModel& model, int a, int b) {
  const auto least = [&](int geom) { return model.geom_solimp[std::ptrdiff_t{mjNIMP} * geom]; };
  return std::min(least(a), least(b));
}

}  // namespace

// MuJoCo's constraint of a contact at rest: R f = k depth, with R = (1 - d) / d times the inverse
// mass of the lighter body, and k = d / (d^2 time^2) for a damping ratio of one.
double yield_under_load(double ratio, double gravity, double contact, double impedance) {
  return (1.0 - impedance) * (1.0 + ratio) * gravity * contact * contact;
}

std::vector<std::string> heavy_loads(const mjModel& model, const mjData& data,
                                     const std::vector<Object>& objects,
                                     const std::vector<int>& object_of) {
  const Vec3 pull = vector(model.opt.gravity);
  const double gravity = pull.norm(), tick = model.opt.timestep;
  if (!(gravity > 0.0)) return {};
  const Vec3 up = -pull / gravity;
  std::vector<LoadedGeom> moving;
  for (int g = 0; g < model.ngeom; ++g) {
    const int body = model.geom_bodyid[g];
    if (object_of[static_cast<std::size_t>(g)] < 0 || model.body_weldid[body] == 0 ||
        !falls(model, data, body, up))
      continue;
    const double middle = up.dot(vector(entry<3>(data.geom_xpos, g)));
    const double half = half_extent_along(model, data, g, up);
    moving.push_back({g, middle - half, middle + half, model.body_mass[body]});
  }

  constexpr std::size_t kMostPairs = 20'000'000, kMostSaid = 16;
  std::size_t pairs = 0, more = 0;
  std::vector<std::string> warnings;
  for (const LoadedGeom& light : moving) {
    const LoadedGeom* heaviest = nullptr;
    for (const LoadedGeom& load : moving) {
      if (++pairs > kMostPairs) break;
      if (load.low + load.high <= light.low + light.high || load.mass <= light.mass) continue;
      if (heaviest != nullptr && load.mass <= heaviest->mass) continue;
      if (!meet(model, light.geom, load.geom) || !overlap(model, data, light.geom, load.geom, up))
        continue;
      heaviest = &load;
    }
    if (heaviest == nullptr) continue;
    const double contact = contact_time(model, light.geom, heaviest->geom);
    const double impedance = impedance_of(model, light.geom, heaviest->geom);
    const double ratio = heaviest->mass / light.mass, height = light.high - light.low;
    const double yield = yield_under_load(ratio, gravity, contact, impedance);
    if (!(yield > kNotableYield * height)) continue;
    if (warnings.size() == kMostSaid) {
      ++more;
      continue;
    }
    const auto name = [&](const LoadedGeom& geom) {
      const int object = object_of[static_cast<std::size_t>(geom.geom)];
      return "'" + objects[static_cast<std::size_t>(object)].name + "'";
    };
    const double share = kNotableYield * height / yield;
    std::string text = "object " + name(*heaviest) + " (" + printed("%.3g kg", heaviest->mass) +
                       ") is above " + name(light) + " (" + printed("%.3g kg", light.mass) + ", " +
                       printed("%.3g mm", 1e3 * height) +
                       " high): where it stands on it, it may sink into what is below by up to " +
                       printed("%.3g mm", 1e3 * yield) + "; make the light one at least " +
                       printed("%.2g kg", light.mass / share);
    if (std::sqrt(share) * tick >= kLeastTick)
      text += ", or give a tick of at most " + printed("%.2g s", std::sqrt(share) * tick);
    warnings.push_back(text);
  }
  if (more > 0)
    warnings.push_back(std::to_string(more) + " more bodies are too light for what is above them");
  return warnings;
}

}  // namespace feltwire::mujoco
