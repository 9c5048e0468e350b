#include "core/guidance/guide.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/splitmix.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::guide_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Guide guide(GuidePlace place, GuideAction action, double max_force = 100.0) {
  Guide g;
  g.name = "guide";
  g.place = std::move(place);
  g.action = std::move(action);
  g.max_force = max_force;
  return g;
}

Vec3 elastic(const Guide& g, const Vec3& p) { return guide_force(g, {p, Vec3::Zero()}).elastic; }

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " is not " << b.transpose();
}

TEST(Guide, SpringTowardsAPointALineACurveAPlane) {
  const Attract spring{.stiffness = 200.0};
  const Vec3 p(0.03, 0.04, 0.1);
  expect_near(elastic(guide(GuidePoint{}, spring), p), -200.0 * p);
  expect_near(elastic(guide(GuideLine{}, spring), p), -200.0 * Vec3(0.03, 0.04, 0.0));
  expect_near(elastic(guide(GuideLine{0.06}, spring), p), -200.0 * Vec3(0.03, 0.04, 0.04));
  expect_near(elastic(guide(Plane{}, spring), p), -200.0 * Vec3(0.0, 0.0, 0.1));
  expect_near(elastic(guide(Plane{}, spring), -p), 200.0 * Vec3(0.0, 0.0, 0.1));

  GuideCurve corner{{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.1, 0.1, 0.0}}, false};
  expect_near(elastic(guide(corner, spring), {0.05, -0.01, 0.0}), {0.0, 2.0, 0.0});
  expect_near(elastic(guide(corner, spring), {0.12, 0.05, 0.0}), {-4.0, 0.0, 0.0});
  const Vec3 beside(0.045, 0.055, 0.0);  // nearest to the segment that closes the curve
  expect_near(elastic(guide(corner, spring), beside), {0.0, -11.0, 0.0});
  corner.closed = true;
  expect_near(elastic(guide(corner, spring), beside), {1.0, -1.0, 0.0});
}

TEST(Guide, SolidsPullFromOutsideAndPushOutFromInside) {
  const Attract pull{.stiffness = 100.0};
  const KeepOut push{.stiffness = 100.0, .damping = 0.0, .margin = 0.01};
  const Sphere ball{0.05};
  expect_near(elastic(guide(ball, pull), {0.0, 0.0, 0.08}), {0.0, 0.0, -3.0});
  expect_near(elastic(guide(ball, pull), {0.0, 0.0, 0.03}), Vec3::Zero());
  expect_near(elastic(guide(ball, push), {0.0, 0.0, 0.07}), Vec3::Zero());
  expect_near(elastic(guide(ball, push), {0.0, 0.055, 0.0}), {0.0, 0.5, 0.0});
  expect_near(elastic(guide(ball, push), {0.0, 0.03, 0.0}), {0.0, 3.0, 0.0});

  const Box box{{0.1, 0.2, 0.3}};
  expect_near(elastic(guide(box, pull), {0.13, 0.24, 0.0}), {-3.0, -4.0, 0.0});
  expect_near(elastic(guide(box, push), {0.09, 0.0, 0.0}), {2.0, 0.0, 0.0});
  expect_near(elastic(guide(box, push), {0.0, -0.195, 0.0}), {0.0, -1.5, 0.0});
  const Cylinder can{0.1, 0.2};
  expect_near(elastic(guide(can, pull), {0.13, 0.0, 0.24}), {-3.0, 0.0, -4.0});
  expect_near(elastic(guide(can, push), {0.0, 0.09, 0.0}), {0.0, 2.0, 0.0});
  expect_near(elastic(guide(can, push), {0.0, 0.01, -0.19}), {0.0, 0.0, -2.0});
  const Capsule rod{0.02, 0.1};
  expect_near(elastic(guide(rod, pull), {0.0, 0.03, 0.14}), {0.0, -1.8, -2.4});
  expect_near(elastic(guide(Plane{}, push), {5.0, 5.0, -0.02}), {0.0, 0.0, 3.0});
}

TEST(Guide, MagnetFieldsAndMedia) {
  const Guide magnet = guide(GuidePoint{}, Magnet{0.02}, 3.0);
  expect_near(elastic(magnet, {0.02, 0.0, 0.0}), {-3.0, 0.0, 0.0});
  expect_near(elastic(magnet, {0.0, 0.04, 0.0}), {0.0, -3.0 * 4.0 / 5.0, 0.0});

  const Guide lift = guide(Everywhere{}, ConstantForce{{0.0, 0.0, 1.5}});
  expect_near(elastic(lift, {3.0, 2.0, 1.0}), {0.0, 0.0, 1.5});
  const Guide wind = guide(Box{{0.1, 0.1, 0.1}}, ConstantForce{{9.0, 12.0, 0.0}}, 5.0);
  expect_near(elastic(wind, {0.05, 0.0, 0.0}), {3.0, 4.0, 0.0});  // max_force in the same direction
  expect_near(elastic(wind, {0.15, 0.0, 0.0}), Vec3::Zero());

  const Guide honey = guide(Sphere{0.1}, Viscosity{10.0}, 4.0);
  const Command slow = guide_force(honey, {{0.05, 0.0, 0.0}, {0.1, 0.0, 0.2}});
  expect_near(slow.frictional, {-1.0, 0.0, -2.0});
  expect_near(slow.elastic, Vec3::Zero());
  const Command fast = guide_force(honey, {{0.05, 0.0, 0.0}, {3.0, 0.0, 4.0}});
  expect_near(fast.frictional, {-2.4, 0.0, -3.2});
  expect_near(guide_force(honey, {{0.15, 0.0, 0.0}, {1.0, 0.0, 0.0}}).force(), Vec3::Zero());
}

TEST(Guide, ItsPoseTurnsAndMovesThePlaceButNotTheForceOfAField) {
  Guide plane = guide(Plane{}, KeepOut{.stiffness = 100.0, .damping = 0.0, .margin = 0.0});
  plane.pose.position = {0.5, 0.0, 0.0};
  plane.pose.orientation =
      // The rotation turns z into x.
      Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
  expect_near(elastic(plane, {0.48, 7.0, 7.0}), {2.0, 0.0, 0.0});
  plane.action = ConstantForce{{0.0, 0.0, 1.0}};
  expect_near(elastic(plane, {0.48, 7.0, 7.0}), {0.0, 0.0, 1.0});
  expect_near(elastic(plane, {0.52, 7.0, 7.0}), Vec3::Zero());
}

TEST(Guide, PullFadesToNothingAtItsRangeWithoutAStep) {
  const Guide spring =
      guide(GuidePoint{}, Attract{.stiffness = 100.0, .damping = 5.0, .range = 0.1}, 4.0);
  double before = 0.0;
  constexpr double kStep = 1e-5;
  for (double d = kStep; d < 0.12; d += kStep) {
    const double force = -elastic(spring, {d, 0.0, 0.0}).x();
    EXPECT_LE(std::abs(force - before), stiffness(spring) * kStep * (1.0 + 1e-9));
    before = force;
  }
  expect_near(elastic(spring, {0.05, 0.0, 0.0}), {-4.0, 0.0, 0.0});  // The limit is 5 N.
  expect_near(elastic(spring, {0.075, 0.0, 0.0}), {-2.0, 0.0, 0.0});
  EXPECT_EQ(guide_force(spring, {{0.1, 0.0, 0.0}, {1.0, 0.0, 0.0}}), Command{});
}

TEST(Guide, DampingActsAlongThePushAndNeverHoldsBack) {
  const Guide wall = guide(Plane{}, KeepOut{.stiffness = 100.0, .damping = 10.0, .margin = 0.0});
  const Vec3 inside(0.0, 0.0, -0.02);
  expect_near(guide_force(wall, {inside, {3.0, 0.0, -0.1}}).frictional, {0.0, 0.0, 1.0});
  expect_near(guide_force(wall, {inside, {0.0, 0.0, 0.1}}).frictional, {0.0, 0.0, -1.0});
  EXPECT_EQ(guide_force(wall, {inside, {0.0, 0.0, 9.0}}).force(), Vec3::Zero());
}

/// Uniform random numbers from -most to most.
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  double operator()(double most) {
    constexpr double kUnit = 0x1p-63;
    return most * (kUnit * static_cast<double>(splitmix::draw(seed_, drawn_++)) - 1.0);
  }

 private:
  std::uint64_t seed_, drawn_ = 0;
};

/// Returns all kinds of guide with a potential, at arbitrary poses.
std::vector<Guide> conservative() {
  std::vector<Guide> all;
  const Attract pull{.stiffness = 300.0, .damping = 2.0, .range = 0.3};
  const KeepOut push{.stiffness = 300.0, .damping = 2.0, .margin = 0.02};
  const std::vector<GuidePlace> places = {
      GuidePoint{},         GuideLine{0.04},         Plane{},
      Sphere{0.05},         Box{{0.03, 0.04, 0.05}}, Capsule{0.02, 0.04},
      Cylinder{0.03, 0.05}, Cone{0.03, 0.04}};
  for (const GuidePlace& place : places)
    for (const GuideAction& action :
         {GuideAction(pull), GuideAction(push), GuideAction(Magnet{0.05})})
      all.push_back(guide(place, action, 4.0));
  all.push_back(guide(Everywhere{}, ConstantForce{{1.0, -2.0, 0.5}}));
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].pose.position = {0.01, -0.02, 0.015};
    all[i].pose.orientation = Quaternion(
        Eigen::AngleAxisd(0.3 + 0.1 * static_cast<double>(i), Vec3(1.0, 2.0, 3.0).normalized()));
  }
  return all;
}

TEST(Guide, GivesNothingOverAClosedPathOutsideOfItsSolid) {
  for (const Guide& g : conservative()) {
    // A closed path around the guide, at least 0.06 m away. The path avoids the inside of solids,
    // because the nearest face jumps there.
    const auto at = [](double t) {
      return Vec3(0.12 * std::cos(t), 0.1 * std::sin(t), 0.05 * std::sin(2.0 * t));
    };
    constexpr int kSteps = 20000;
    double work = 0.0, exchanged = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double step = 2.0 * std::numbers::pi / kSteps;
      const Vec3 way = at((i + 1) * step) - at(i * step);
      const double part = elastic(g, at((i + 0.5) * step)).dot(way);
      work += part;
      exchanged += std::abs(part);
    }
    EXPECT_LE(std::abs(work), 1e-6 * exchanged + 1e-12)
        << g.place.index() << ' ' << g.action.index();
  }
}

TEST(Guide, NeverMoreThanItsMaximumAndDampingOnlyTakes) {
  Random number(7);
  std::vector<Guide> all = conservative();
  all.push_back(guide(Everywhere{}, Viscosity{20.0}, 4.0));
  for (const Guide& g : all) {
    for (int i = 0; i < 2000; ++i) {
      const Tool tool{{number(0.2), number(0.2), number(0.2)}, {number(5), number(5), number(5)}};
      const Command command = guide_force(g, tool);
      ASSERT_LE(command.elastic.norm(), g.max_force * (1.0 + 1e-12));
      ASSERT_LE(command.force().norm(), g.max_force * (1.0 + 1e-12));
      ASSERT_LE(command.frictional.dot(tool.velocity), 1e-12);
      ASSERT_EQ(command.elastic, elastic(g, tool.position));
    }
  }
}

TEST(Guide, BeginsWhereItSaysSo) {
  Random number(11);
  std::vector<Guide> all = conservative();
  all.push_back(guide(Box{{0.03, 0.04, 0.05}}, Viscosity{20.0}));
  for (const Guide& g : all) {
    int free = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p(number(0.5), number(0.5), number(0.5));
      const double distance = begins(g, p);
      free += distance > 0.0;
      const Vec3 way = Vec3(number(1), number(1), number(1)).normalized();
      const Tool within{p + 0.999 * distance * way, {1.0, 1.0, 1.0}};
      if (distance > 0.0) {
        ASSERT_EQ(guide_force(g, within), Command{}) << g.place.index();
      }
    }
    const bool endless =
        std::get_if<Magnet>(&g.action) != nullptr || std::get_if<Everywhere>(&g.place) != nullptr;
    EXPECT_EQ(free == 0, endless) << g.place.index() << ' ' << g.action.index();
  }
}

TEST(Guide, NotFinite) {
  for (const Guide& g : conservative()) {
    EXPECT_EQ(guide_force(g, {{NAN, 0.0, 0.0}, Vec3::Zero()}), Command{});
    EXPECT_EQ(guide_force(g, {Vec3::Zero(), {0.0, kInfinity, 0.0}}), Command{});
    EXPECT_TRUE(guide_force(g, {Vec3::Constant(1e3), Vec3::Zero()}).finite());
    EXPECT_TRUE(guide_force(g, {g.pose.position, Vec3::Zero()}).finite());
  }
}

constexpr const char* kWall = R"("materials": [{"name": "m", "stiffness": 500}],
  "objects": [{"name": "wall", "plane": {}, "material": "m"}],)";

Scene scene(const std::string& guides) {
  return parse_scene(R"({"name": "s", )" + std::string(kWall) + R"("guides": [)" + guides + "]}",
                     "s.json");
}

TEST(GuideFile, EveryKindIsReadAndAddsToTheObjects) {
  const Scene s = scene(R"(
    {"name": "home", "point": {}, "position": [0, 0, 0.1], "attract": {"stiffness": 100, "range": 0.2}, "max_force": 5},
    {"name": "rail", "line": {"length": 0.2}, "magnet": {"reach": 0.01}, "max_force": 2},
    {"name": "road", "curve": {"points": [[0,0,0],[1,0,0]], "closed": true}, "attract": {"stiffness": 1}, "max_force": 2},
    {"name": "roof", "plane": {}, "orientation": [0, 1, 0, 0], "keep_out": {"stiffness": 10}, "position": [0,0,1], "max_force": 2},
    {"name": "honey", "box": {"size": [1, 1, 1]}, "viscosity": {"damping": 3}, "max_force": 2},
    {"name": "lift", "constant": {"force": [0, 0, 1]}, "max_force": 2})");
  ASSERT_EQ(s.guides().size(), 6u);
  EXPECT_TRUE(s.requirements().guides);
  EXPECT_TRUE(s.requirements().velocity);
  EXPECT_EQ(std::get<GuideLine>(s.guides()[1].place).half_length, 0.1);
  EXPECT_EQ(std::get<Attract>(s.guides()[2].action).range, kInfinity);
  EXPECT_TRUE(std::get<GuideCurve>(s.guides()[2].place).closed);

  TouchMemory memory = s.memory();
  const Tool tool{{0.0, 0.0, -0.01}, {0.1, 0.0, 0.0}};
  const Command wall = touch(s.objects()[0], tool, memory[0]);
  Vec3 guides = Vec3::Zero();
  for (const Guide& g : s.guides()) guides += guide_force(g, tool).force();
  TouchMemory other = s.memory();
  const Command both = s.touch(tool, other);
  EXPECT_EQ(both.elastic, wall.elastic);  // the normal of the contact alone
  EXPECT_LT((both.frictional - wall.frictional - guides).norm(), 1e-12);
  EXPECT_LT(both.frictional.x(), -0.29);
}

TEST(GuideFile, AloneMakesAScene) {
  const Scene s = parse_scene(
      R"({"name": "s", "materials": [], "objects": [],
          "guides": [{"name": "g", "point": {}, "attract": {"stiffness": 7}, "max_force": 1}]})",
      "s.json");
  EXPECT_EQ(s.requirements().stiffness, 7.0);
  EXPECT_FALSE(s.requirements().velocity);
  TouchMemory memory = s.memory();
  expect_near(s.touch({{0.1, 0.0, 0.0}, Vec3::Zero()}, memory).elastic, {-0.7, 0.0, 0.0});
}

TEST(GuideFile, LocalModelReachesToWhereAGuideBegins) {
  const Scene s = scene(
      R"({"name": "g", "sphere": {"radius": 0.01}, "position": [0, 0, 0.05], "keep_out": {"stiffness": 9, "margin": 0.01}, "max_force": 1})");
  const TouchMemory memory = s.memory();
  EXPECT_NEAR(local_model(s, {0.0, 0.0, 0.005}, memory).reach, 0.025, 1e-12);
  EXPECT_EQ(local_model(s, {0.0, 0.0, 0.045}, memory).reach, 0.0);
}

TEST(GuideFile, NeverAllocatesWhenTouched) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const Scene s = scene(
      R"({"name": "road", "curve": {"points": [[0,0,0],[1,0,0],[1,1,0]]}, "attract": {"stiffness": 1}, "max_force": 2})");
  TouchMemory memory = s.memory();
  const std::size_t before = test::allocations();
  const Command command = s.touch({{0.3, 0.2, 0.1}, Vec3::Zero()}, memory);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_LT(command.force().y(), 0.0);
}

struct Bad {
  const char* guide;
  const char* message;
};

TEST(GuideFile, MistakesAreNamed) {
  const std::vector<Bad> all = {
      {R"({"name": "g", "attract": {"stiffness": 1}, "max_force": 1})", "attract: needs a place"},
      {R"({"name": "g", "point": {}, "max_force": 1})",
       "does nothing; give exactly one of attract"},
      {R"({"name": "g", "point": {}, "plane": {}, "magnet": {"reach": 1}, "max_force": 1})",
       "plane: stands beside point"},
      {R"({"name": "g", "point": {}, "magnet": {"reach": 1}, "attract": {"stiffness": 1}, "max_force": 1})",
       "magnet: stands beside attract"},
      {R"({"name": "g", "point": {}, "attract": {}, "max_force": 1})",
       "attract.stiffness: is not given"},
      {R"({"name": "g", "point": {}, "attract": {"stiffness": 1, "range": -1}, "max_force": 1})",
       "attract.range: must be above zero"},
      {R"({"name": "g", "point": {}, "keep_out": {"stiffness": 1}, "max_force": 1})",
       "keep_out.margin: must be above zero"},
      {R"({"name": "g", "line": {"length": 0}, "attract": {"stiffness": 1}, "max_force": 1})",
       "line.length: must be above zero"},
      {R"({"name": "g", "curve": {"points": [[0,0,0]]}, "attract": {"stiffness": 1}, "max_force": 1})",
       "curve.points: are fewer than two"},
      {R"({"name": "g", "sphere": {"radius": 0}, "attract": {"stiffness": 1}, "max_force": 1})",
       "sphere.radius: must be above zero"},
      {R"({"name": "g", "point": {}, "viscosity": {"damping": 1}, "max_force": 1})",
       "viscosity: acts inside its place"},
      {R"({"name": "g", "constant": {"force": [0, 0, 0]}, "max_force": 1})",
       "constant.force: has no direction"},
      {R"({"name": "g", "constant": {}, "max_force": 1})", "constant.force: is missing"},
      {R"({"name": "g", "constant": {"force": [0, 0, 1]}})", "max_force: is not given"},
      {R"({"name": "", "constant": {"force": [0, 0, 1]}, "max_force": 1})", "name: must be 1 to"},
  };
  for (const Bad& bad : all) {
    try {
      scene(bad.guide);
      ADD_FAILURE() << "accepted: " << bad.guide;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), StartsWith("s.json:2: guides[0]")) << bad.guide;
      EXPECT_THAT(error.what(), HasSubstr(bad.message));
    }
  }
}

}  // namespace
}  // namespace feltwire::guide_test
