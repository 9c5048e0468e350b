#include "core/dynamics/mass_properties.hpp"

#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

/// Returns the inertia [m^2, per unit of mass] that the offset `by` [m] from the centre of mass
/// adds (Steiner's theorem).
Mat3 offset_inertia(const Vec3& by) {
  return by.squaredNorm() * Mat3::Identity() - by * by.transpose();
}

}  // namespace

MassProperties mass_properties(const Shape& shape) {
  if (const auto* m = std::get_if<Mesh>(&shape)) {
    const TriangleMesh& mesh = m->surface->mesh();
    const bool solid = mesh.report().closed() && mesh.report().volume > 0.0;
    return solid ? mass_properties(mesh) : MassProperties{};
  }
  return on_primitive(
      shape, [](const auto& solid) { return solid.mass_properties(); },
      [] { return MassProperties{}; });
}

// Computes sums over the tetrahedra from the origin to each triangle (Tonon 2004, "Explicit exact
// formulas for the 3-D tetrahedron inertia tensor"). Lengths are divided by the size of the mesh,
// as in TriangleMesh::volume().
MassProperties mass_properties(const TriangleMesh& mesh) {
  const double size = mesh.half_extents().maxCoeff();
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // integral of x x^T
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const auto corners = mesh.corners(t);
    const Vec3 a = corners[0] / size, b = corners[1] / size, c = corners[2] / size;
    const Vec3 sum = a + b + c;
    const double determinant = a.dot(b.cross(c));
    volume += determinant / 6.0;
    first += determinant / 24.0 * sum;
    second += determinant / 120.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Vec3 center = first / volume;
  second -= volume * center * center.transpose();
  const double scale = size * size * size;
  return {scale * volume, mesh.origin() + size * center,
          scale * size * size * (second.trace() * Mat3::Identity() - second)};
}

MassProperties placed(const MassProperties& solid, const Pose& pose) {
  const Mat3 turn = pose.orientation.toRotationMatrix();
  return {solid.volume, pose.position + turn * solid.center,
          turn * solid.inertia * turn.transpose()};
}

MassProperties together(const MassProperties& a, const MassProperties& b) {
  const double volume = a.volume + b.volume;
  const Vec3 center = (a.volume * a.center + b.volume * b.center) / volume;
  return {volume, center,
          a.inertia + a.volume * offset_inertia(a.center - center) + b.inertia +
              b.volume * offset_inertia(b.center - center)};
}

bool is_convex(const TriangleMesh& mesh) {
  // Largest rounding error of a flat face, as a share of the mesh's size.
  constexpr double kFlat = 1e-9;
  if (!mesh.report().closed()) return false;
  // Test for handles by Euler's formula: a surface without handles has vertices - edges + triangles
  // = 2. A closed surface has 3/2 edges per triangle.
  if (2 * mesh.vertices().size() != mesh.triangles().size() + 4) return false;
  const double flat = kFlat * mesh.half_extents().maxCoeff();
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const auto corners = mesh.corners(t);
    const Vec3 normal = triangle_normal(corners);
    for (int k = 0; k < 3; ++k)
      for (const std::uint32_t v : mesh.triangles()[mesh.neighbour(t, k)])
        if (normal.dot(mesh.vertices()[v] - corners[0]) > flat) return false;
  }
  return true;
}

}  // namespace feltwire
