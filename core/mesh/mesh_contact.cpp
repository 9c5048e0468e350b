#include "core/mesh/mesh_contact.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "core/mesh/height_map.hpp"

namespace feltwire {
namespace {

std::int8_t sides_of(const MeshSurface& surface, Side felt_from) {
  if (surface.options().double_sided) return 0;
  return felt_from == Side::outside ? 1 : -1;
}

/// Returns the proxy of a tool without a previous state. Inside a closed surface, this is the
/// nearest surface point, as if the tool had entered there.
ProxyState first_stand(const MeshSurface& surface, std::int8_t sides, const Vec3& goal,
                       WorkLimit* work) {
  ProxyState proxy{.point = goal, .triangle = 0, .side = 0, .on_face = false};
  if (sides == 0 || !surface.mesh().report().closed()) return proxy;
  const auto nearest = surface.nearest(goal, std::numeric_limits<double>::infinity(), work);
  if (!(sides * surface.side_of(goal, nearest, work) < 0.0)) return proxy;
  return {.point = nearest.point, .triangle = nearest.triangle, .side = sides, .on_face = false};
}

/// Returns the proxy of a ball without a previous state. If the ball overlaps the solid, the proxy
/// starts in front of the nearest point.
ProxyState first_ball(const MeshSurface& surface, double radius, std::int8_t sides,
                      const Vec3& goal, WorkLimit* work) {
  ProxyState proxy = first_stand(surface, sides, goal, work);
  if (proxy.side != 0) {
    proxy.point += radius * proxy.side * triangle_normal(surface.mesh().corners(proxy.triangle));
    return proxy;
  }
  auto nearest = surface.nearest(goal, radius, work);
  if (!(nearest.distance < radius)) return proxy;
  Vec3 normal = triangle_normal(surface.mesh().corners(nearest.triangle));
  double side = normal.dot(goal - nearest.point) < 0.0 ? -1.0 : 1.0;
  if (sides * side < 0.0) {
    const std::uint32_t reverse = surface.mesh().reverse_of(nearest.triangle);
    if (reverse == TriangleMesh::kNone) return proxy;
    nearest.triangle = reverse;
    normal = -normal;
    side = -side;
  }
  const Vec3 out =
      nearest.distance > 0.0 ? direction(Vec3(goal - nearest.point)) : Vec3(side * normal);
  proxy.point = nearest.point + radius * out;
  proxy.triangle = nearest.triangle;
  proxy.side = side < 0.0 ? -1 : 1;
  return proxy;
}

Vec3 smooth_normal(const MeshSurface& surface, const ProxyState& proxy) {
  const auto on = nearest_on_triangle(surface.mesh().corners(proxy.triangle), proxy.point);
  const Triangle& corner = surface.mesh().triangles()[proxy.triangle];
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    sum += on.weights[static_cast<Eigen::Index>(k)] * surface.normals()[corner[k]];
  return proxy.side * direction(sum);
}

constexpr std::size_t kWaves = 8;

/// Returns a direction of a wave. The directions are spread evenly over a half ball (a Fibonacci
/// lattice).
Vec3 wave_direction(std::size_t i) {
  constexpr double kGoldenAngle = 2.399963229728653;  // [rad]
  const double z = (static_cast<double>(i) + 0.5) / kWaves, r = std::sqrt(1.0 - z * z);
  const double turn = kGoldenAngle * static_cast<double>(i);
  return {r * std::cos(turn), r * std::sin(turn), z};
}
const std::array<Vec3, kWaves> kWaveDirections = [] {
  std::array<Vec3, kWaves> all;
  for (std::size_t i = 0; i < kWaves; ++i) all[i] = wave_direction(i);
  return all;
}();

/// Returns a sum of waves. Their phases differ, so that the grain does not repeat. The cut is
/// between 0 and 2 amplitudes deep.
Relief relief_of(const Grain& grain, const Vec3& point) {
  const double k = 2.0 * std::numbers::pi / grain.wavelength;  // [1/m] wave number
  Relief relief{.cut = grain.amplitude, .slope = Vec3::Zero()};
  for (std::size_t i = 0; i < kWaves; ++i) {
    constexpr double kPhase = 1.9;  // [rad] phase between two waves
    const double at = k * kWaveDirections[i].dot(point) + kPhase * static_cast<double>(i);
    relief.cut -= grain.amplitude / kWaves * std::sin(at);
    relief.slope -= grain.amplitude / kWaves * k * std::cos(at) * kWaveDirections[i];
  }
  return relief;
}

/// Returns the contact with a surface that is lowered by the relief. The spring's energy is 1/2 k
/// (depth - cut)^2. So the force has a component along the slope (Minsky's lateral force), and a
/// closed path neither takes nor gives energy.
SurfacePoint lowered(const SurfacePoint& surface, const Relief& relief) {
  if (relief.cut == 0.0 && relief.slope.isZero(0.0)) return surface;
  const Vec3 slope = relief.slope - along(relief.slope, surface.normal);
  const double depth = surface.depth - relief.cut;
  if (!(depth > 0.0)) return {};
  const Vec3 push = surface.normal + slope;
  const double stretched = length(push);
  return {surface.point, push / stretched, depth * stretched};
}

SurfacePoint textured(const MeshOptions& options, const SurfacePoint& surface) {
  Relief relief;
  if (options.grain.amplitude > 0.0) relief = relief_of(options.grain, surface.point);
  if (options.height_map) {
    const Relief map = options.height_map->at(surface.point, surface.normal);
    relief.cut += map.cut;
    relief.slope += map.slope;
  }
  return lowered(surface, relief);
}

}  // namespace

SurfacePoint mesh_surface_point(const MeshSurface& surface, Side felt_from, const Vec3& position,
                                FeatureMemory& memory, double radius, WorkLimit* work) noexcept {
  const Vec3 goal = position - surface.mesh().origin();
  if (!goal.allFinite()) return {};
  const double around = surface.options().radius + radius;
  const bool ball = around > 0.0;
  const std::int8_t sides = sides_of(surface, felt_from);
  ProxyState proxy{memory.proxy, memory.triangle, memory.side, false};
  if (!memory.tracked)
    proxy = ball ? first_ball(surface, around, sides, goal, work)
                 : first_stand(surface, sides, goal, work);
  if (ball)
    move_ball(surface, around, sides, goal, proxy, work);
  else
    move_point(surface, sides, goal, proxy, work);
  if (is_cut(work)) [[unlikely]]
    return {};

  memory.proxy = proxy.point;
  memory.triangle = proxy.triangle;
  memory.side = proxy.side;
  memory.tracked = true;
  const Vec3 beyond = proxy.point - goal;
  const double depth = length(beyond);
  if (proxy.side == 0 || !(depth > 0.0)) {
    memory.feature = 0;
    return {};
  }
  memory.feature = 1;
  Vec3 normal = direction(beyond);
  if (proxy.on_face && !ball)
    normal = proxy.side * triangle_normal(surface.mesh().corners(proxy.triangle));
  if (surface.options().smooth) {
    const Vec3 shaded = smooth_normal(surface, proxy);
    if (!shaded.isZero(0.0)) normal = shaded;
  }
  const SurfacePoint smooth{surface.mesh().origin() + proxy.point, normal, depth};
  SurfacePoint found = surface.options().rough() ? textured(surface.options(), smooth) : smooth;
  if (!(found.depth > 0.0)) {
    memory.feature = 0;
    return {};
  }
  memory.normal = found.normal;
  return found;
}

}  // namespace feltwire
