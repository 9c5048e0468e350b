// A body whose inertia MuJoCo cannot simulate is refused when the scene is made.
#include <gmock/gmock.h>

#include <stdexcept>

#include "tests/core/moving.hpp"

namespace feltwire::least_inertia_test {
namespace {

using ::testing::HasSubstr;

TEST(LeastInertia, ABodyThatIsTooSmallIsRefusedByItsName) {
  const auto speck = [](double size) {
    return test::moving({test::object("speck", Box{Vec3::Constant(0.5 * size)})}, {0},
                        {test::body("speck", 1e-6)});
  };
  EXPECT_NO_THROW(speck(1e-4));
  try {
    speck(1e-5);
    FAIL() << "not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("body 'speck': mass: gives it an inertia of 1.67e-17 kg "
                                        "m^2, must be above 1e-15; make it larger or heavier"));
  }
}

}  // namespace
}  // namespace feltwire::least_inertia_test
