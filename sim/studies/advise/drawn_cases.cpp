#include "sim/studies/advise/drawn_cases.hpp"

#include <cmath>

#include "core/base/splitmix.hpp"
#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"

namespace feltwire::advise {
namespace {

constexpr double kApart = 0.5;  // [m] from one object to the next

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : seed_(splitmix::mix(seed)) {}
  double even(double low, double high) {
    constexpr double kBits = 0x1p-53;
    return low + (high - low) * kBits * static_cast<double>(splitmix::draw(seed_, next_++) >> 11);
  }
  double log(double low, double high) { return low * std::pow(high / low, even(0.0, 1.0)); }
  bool chance(double share) { return even(0.0, 1.0) < share; }
  int below(int count) { return static_cast<int>(even(0.0, count)); }

 private:
  std::uint64_t seed_, next_ = 0;
};

DeviceSpec drawn_device(Draws& draws) {
  DeviceSpec spec = builtin_device("simulated");
  spec.name = "drawn";
  spec.damping = draws.log(0.005, 5.0);
  spec.apparent_mass = draws.log(0.04, 0.3);
  spec.least_mass = draws.chance(0.8) ? 0.8 * spec.apparent_mass : 0.0;
  spec.coulomb_friction = draws.chance(0.8) ? draws.log(0.02, 0.4) : 0.0;
  spec.least_friction = draws.chance(0.7) ? 0.75 * spec.coulomb_friction : 0.0;
  spec.position_resolution = draws.log(3e-6, 50e-6);
  spec.max_force = draws.log(4.0, 20.0);
  spec.continuous_force = draws.even(0.3, 1.0) * spec.max_force;
  if (draws.chance(0.6)) {
    spec.actuation.lag = draws.log(0.05e-3, 0.8e-3);
    spec.actuation.kind = draws.chance(0.5) ? LagKind::filter : LagKind::delay;
  }
  if (draws.chance(0.5)) spec.transmission.stiffness = draws.log(3e3, 30e3);
  validate(spec);
  return spec;
}

std::string drawn_link(Draws& draws) {
  const double delay = draws.log(0.1, 75.0);  // [ms] one way
  std::string text;
  append(text, "delay=%.4f", delay);
  if (draws.chance(0.6))
    append(text, ",jitter=%.4f,distribution=%s", draws.even(0.01, 0.15) * delay,
           draws.chance(0.5) ? "normal" : "pareto");
  if (draws.chance(0.5)) {
    append(text, ",loss=%.4f", draws.log(0.05, 5.0));
    if (draws.chance(0.5)) append(text, ",burst=%.2f", draws.even(1.5, 5.0));
  }
  if (draws.chance(0.25)) append(text, ",rate=%.4f", draws.log(0.1, 3.0));
  return text;
}

Object drawn_object(Draws& draws, int index, Place& place) {
  Object object;
  object.name = "object " + std::to_string(index);
  object.pose.position = Vec3(index * kApart, 0.0, 0.0);
  object.material.stiffness = draws.log(200.0, 20e3);
  if (draws.chance(0.5)) {
    object.material.static_friction = draws.even(0.1, 0.8);
    object.material.dynamic_friction = 0.8 * object.material.static_friction;
  }
  if (draws.chance(0.3)) object.material.damping = draws.log(0.1, 2.0);
  const double size = draws.even(0.03, 0.08);  // [m]
  // A plane has no end, so it is the only object of its scene.
  switch (draws.below(index == 0 ? 6 : 5)) {
    case 0:
      object.shape = Sphere{size};
      break;
    case 1:
      object.shape = Box{Vec3(1.2 * size, size, size)};
      break;
    case 2:
      object.shape = Cylinder{.radius = size, .half_length = size};
      break;
    case 3:
      object.shape = Capsule{.radius = size, .half_length = 0.5 * size};
      break;
    case 4:
      object.shape = Mesh{
          std::make_shared<MeshSurface>(TriangleMesh(tessellate(Box{Vec3(size, size, size)}, 8)))};
      break;
    default:
      object.shape = Plane{};
  }
  double top = size;
  if (std::holds_alternative<Capsule>(object.shape)) top = 1.5 * size;
  if (std::holds_alternative<Plane>(object.shape)) top = 0.0;
  place.point = object.pose.position + top * Vec3::UnitZ();
  place.normal = Vec3::UnitZ();
  place.object = object.name;
  place.material = object.material;
  return object;
}

}  // namespace

DrawnCase drawn_case(std::uint64_t seed) {
  Draws draws(seed);
  DeviceSpec device = drawn_device(draws);
  std::string link = drawn_link(draws);
  std::vector<Object> objects;
  std::vector<Place> places;
  const int wanted = 1 + draws.below(3);
  for (int i = 0; i < wanted; ++i) {
    Place place;
    objects.push_back(drawn_object(draws, i, place));
    places.push_back(place);
    if (std::holds_alternative<Plane>(objects.back().shape)) break;
  }
  const Hand hand{.mass = draws.log(0.02, 0.15),
                  .damping = draws.log(0.7, 7.0),
                  .stiffness = draws.log(60.0, 400.0)};
  const double lead_in = draws.even(0.7, 1.3);
  return {.seed = seed,
          .device = std::move(device),
          .link = std::move(link),
          .scene = Scene("drawn", std::move(objects)),
          .places = std::move(places),
          .hand = hand,
          .lead_in = lead_in};
}

std::vector<DrawnCase> drawn_cases(std::uint64_t seed, int count) {
  std::vector<DrawnCase> cases;
  cases.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) cases.push_back(drawn_case(seed + static_cast<std::uint64_t>(i)));
  return cases;
}

}  // namespace feltwire::advise
