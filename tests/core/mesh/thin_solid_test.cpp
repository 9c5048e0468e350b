// The loader warns of solids of triangles that are too thin to hold a hand.
#include "core/mesh/thin_solid.hpp"

#include <gmock/gmock.h>

#include "core/mesh/mesh_contact.hpp"
#include "core/mesh/tessellation.hpp"

namespace feltwire::thin_solid_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Optional;

MeshSurface plate(double thickness, double width) {
  return MeshSurface(TriangleMesh(tessellate(Box{0.5 * Vec3(width, width, thickness)}, 3)));
}

/// [m] The depth of a hand that goes straight down by 2 % of the width, through the plate.
double held(const MeshSurface& surface, double width) {
  FeatureMemory memory;
  SurfacePoint last;
  for (int n = -4; n <= 4; ++n)
    last =
        mesh_surface_point(surface, Side::outside, width * Vec3(0.01, 0.02, -0.0025 * n), memory);
  return last.depth;
}

TEST(ThinSolid, IsSaidWithBothLengthsAndTheRemedy) {
  EXPECT_THAT(warning_of_thin_solid(plate(1e-7, 1.0)),
              Optional(HasSubstr("is 1e-07 m thin and 1 m large: a hand may pass through it; make "
                                 "it at least 4.77e-07 m thick")));
}

TEST(ThinSolid, AThickerOneHoldsAHand) {
  for (const double width : {1e-3, 1.0, 1e3}) {
    const MeshSurface surface = plate(1e-6 * width, width);
    EXPECT_EQ(warning_of_thin_solid(surface), std::nullopt) << width;
    EXPECT_GT(held(surface, width), 0.9e-2 * width) << width;
  }
}

TEST(ThinSolid, AnOpenSheetIsNone) {
  const TriangleSoup sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  EXPECT_EQ(warning_of_thin_solid(MeshSurface(TriangleMesh(sheet))), std::nullopt);
}

}  // namespace
}  // namespace feltwire::thin_solid_test
