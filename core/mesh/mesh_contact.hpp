#pragma once
// The proxy of a tool on a triangle mesh: the god-object of Zilles & Salisbury (1995) for a point,
// the ball of Ruspini, Kolarov & Khatib (1997) for a tool with a radius.
//
// The proxy is the place of the tool if the tool could not pass the surface. It follows the tool on
// the shortest way that stays in front of all triangles. A tool is therefore felt at any speed, and
// a sheet keeps it on the side that it came from. Arguments of both:
//   goal      the tool [m, from the mesh's origin]
//   sides     which sides of a triangle can be felt: 1 where its normal points, -1 behind, 0 both

#include "core/geometry/shapes.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// The proxy of a point [m, object frame], as surface_point() says. With a `radius` [m], the proxy
/// is the middle of a ball; the radius is added to that of the surface's own options. Where `work`
/// is cut off, the memory stays as it was and the result means nothing.
SurfacePoint mesh_surface_point(const MeshSurface& surface, Side felt_from, const Vec3& position,
                                FeatureMemory& memory, double radius = 0.0,
                                WorkLimit* work = nullptr) noexcept;

/// The place of a proxy.
struct ProxyState {
  Vec3 point = Vec3::Zero();  // [m]
  std::uint32_t triangle = 0;
  std::int8_t side = 0;  // of the triangle; 0: free
  bool on_face = false;  // held by this one triangle alone
};

/// Moves the proxy of a point towards the goal, until it is there or no allowed movement brings it
/// nearer.
void move_point(const MeshSurface& surface, std::int8_t sides, const Vec3& goal, ProxyState& proxy,
                WorkLimit* work = nullptr) noexcept;

/// As above, for the middle of a ball of `radius` [m], > 0.
void move_ball(const MeshSurface& surface, double radius, std::int8_t sides, const Vec3& goal,
               ProxyState& proxy, WorkLimit* work = nullptr) noexcept;

}  // namespace feltwire
