// Compares the surface of a distance field with known surfaces of solids.

#include "core/grid/isosurface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/grid/signed_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::isosurface_test {
namespace {

/// The surface must be closed, its normals must point outwards, and it must contain the points of
/// the solid.
TEST(Isosurface, HoldsTheSolid) {
  struct Case {
    Shape shape;
    double volume, tolerance;
  };
  const double r = 0.05;
  for (const Case& solid : {Case{Sphere{r}, 4.0 / 3.0 * M_PI * r * r * r, 0.02},
                            Case{Box{Vec3(0.03, 0.05, 0.02)}, 8 * 0.03 * 0.05 * 0.02, 0.1}}) {
    const DistanceGrid<float> grid(solid_of(solid.shape), {.resolution = 2e-3});
    const TriangleSoup soup = isosurface(grid, 32);
    const TriangleMesh mesh(soup);
    EXPECT_TRUE(mesh.report().closed());
    EXPECT_NEAR(mesh.report().volume / solid.volume, 1.0, solid.tolerance);
    const double cell = (grid.high() - grid.low()).maxCoeff() / 32;
    for (const Vec3& vertex : soup.vertices)
      EXPECT_LT(std::abs(signed_distance(solid.shape, Side::outside, vertex).distance), cell);
  }
}

TEST(Isosurface, RefusesImpossibleSteps) {
  const DistanceGrid<float> grid(solid_of(Sphere{0.05}), {.resolution = 5e-3});
  for (const int steps : {-1, 0, 1, 257})
    EXPECT_THROW(isosurface(grid, steps), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::isosurface_test
