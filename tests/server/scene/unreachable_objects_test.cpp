// The loader warns of objects that no hand can touch.
#include "server/scene/unreachable_objects.hpp"

#include <gmock/gmock.h>

#include "protocol/wire/datagram.hpp"

namespace feltwire::unreachable_objects_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Optional;

Object ball_at(const char* name, double place) {
  Object ball;
  ball.name = name;
  ball.shape = Sphere{0.5};
  ball.pose.position.y() = place;
  return ball;
}

TEST(UnreachableObjects, AreSaidWithTheRemedy) {
  const Scene scene("far", {ball_at("near", 0.0), ball_at("far", -1e6)});
  EXPECT_THAT(warning_of_unreachable_objects(scene),
              Optional(AllOf(HasSubstr("touch 'far': "), Not(HasSubstr("near'")),
                             HasSubstr("1000 m"), HasSubstr("move the origin"))));
}

TEST(UnreachableObjects, AnObjectThatAHandJustReachesIsNotOne) {
  EXPECT_EQ(warning_of_unreachable_objects(Scene("edge", {ball_at("edge", kMaxPosition + 0.4)})),
            std::nullopt);
  EXPECT_NE(warning_of_unreachable_objects(Scene("edge", {ball_at("edge", kMaxPosition + 0.6)})),
            std::nullopt);
}

TEST(UnreachableObjects, AnEndlessOneIsReached) {
  Object plane;
  plane.name = "plane";
  plane.shape = Plane{};
  plane.pose.position.x() = 1e6;
  EXPECT_EQ(warning_of_unreachable_objects(Scene("plane", {plane})), std::nullopt);
}

}  // namespace
}  // namespace feltwire::unreachable_objects_test
