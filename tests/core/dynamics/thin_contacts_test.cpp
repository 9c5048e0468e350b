// Thin bodies that fall onto thin bodies: what the loader says, and what the simulation does.
#include "core/dynamics/thin_contacts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/moving.hpp"

namespace feltwire::thin_contacts_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kGravity = 9.81;

struct Drop {
  Shape shape = Box{Vec3(0.05, 0.05, 0.0005)};
  double half = 0.0005;  // [m] of its height
  double board = 0.001;  // [m] thickness
  double height = 0.25;  // [m] from the board to its lowest point
  double tick = 1e-3;    // [s]
  Quaternion turn = Quaternion::Identity();
};

Scene scene_of(const Drop& drop) {
  std::vector<Object> objects = {test::object("board", Box{Vec3(0.1, 0.1, 0.5 * drop.board)},
                                              {.stiffness = 1000}, {0, 0, 0.05 - 0.5 * drop.board}),
                                 test::object("floor", Plane{}, {.stiffness = 1000}),
                                 test::object("plate", drop.shape, {.stiffness = 1000},
                                              {0, 0, 0.05 + drop.height + drop.half})};
  objects[2].pose.orientation = drop.turn;
  return test::moving(std::move(objects), {-1, -1, 0},
                      {test::body("plate", 0.1, {0, 0, 0.05 + drop.height + drop.half})},
                      {.tick = drop.tick});
}

/// Whether it lies on the board after a second of the fall.
bool holds(const Drop& drop) {
  const Scene scene = scene_of(drop);
  World world(scene);
  const double until = std::sqrt(2.0 * drop.height / kGravity) + 0.5;
  for (double t = 0.0; t < until; t += drop.tick) world.step();
  return world.objects()[2].pose.position.z() > 0.045;
}

std::vector<std::string> thin_warnings(const Drop& drop) {
  std::vector<std::string> thin;
  const Scene scene = scene_of(drop);
  for (const std::string& warning : scene.warnings())
    if (warning.find("may fall through") != std::string::npos) thin.push_back(warning);
  return thin;
}

TEST(ThinContacts, APlateThatFallsThroughABoardIsSaidWithNumbersAndRemedy) {
  Drop drop;
  // A tick may find the plate in the board or beyond it: where it begins decides.
  int fell = 0;
  for (int i = 0; i < 8; ++i) {
    drop.height = 0.25 + 0.0003 * i;
    fell += holds(drop) ? 0 : 1;
  }
  EXPECT_GT(fell, 0);
  drop.height = 0.25;
  EXPECT_THAT(thin_warnings(drop),
              ::testing::ElementsAre(
                  AllOf(HasSubstr("object 'plate' (1 mm thick) falls 0.25 m onto 'board' (1 mm)"),
                        HasSubstr("comes with 2.21 m/s"), HasSubstr("tick of 1 ms"),
                        HasSubstr("up to 0.402 m/s"), HasSubstr("mm thick together"),
                        HasSubstr("or give a tick of at most"), HasSubstr("begin at most"))));
}

/// Bodies that are not warned of hold, for any shape, size, tick and height; each remedy is one.
TEST(ThinContacts, WhatIsNotWarnedOfHolds) {
  int warned = 0, silent = 0;
  const auto look = [&](const Drop& drop) {
    if (!thin_warnings(drop).empty()) {
      ++warned;
      return;
    }
    ++silent;
    EXPECT_TRUE(holds(drop)) << drop.half << " " << drop.board << " " << drop.height << " "
                             << drop.tick;
  };
  for (const double thick : {0.001, 0.003, 0.01})
    for (const double board : {0.001, 0.003, 0.01})
      for (const double height : {0.002, 0.01, 0.05, 0.25})
        for (const double tick : {2e-4, 1e-3}) {
          const double half = 0.5 * thick;
          look({Box{Vec3(0.05, 0.05, half)}, half, board, height, tick});
          look({Cylinder{0.02, half}, half, board, height, tick});
          look({Sphere{half}, half, board, height, tick});
        }
  EXPECT_GT(warned, 30);
  EXPECT_GT(silent, 30);
}

TEST(ThinContacts, TheRemediesHelp) {
  Drop thicker;
  thicker.board = 0.0115;
  EXPECT_THAT(thin_warnings(thicker), IsEmpty());
  EXPECT_TRUE(holds(thicker));
  Drop finer;
  finer.tick = 1.7e-4;
  EXPECT_THAT(thin_warnings(finer), IsEmpty());
  EXPECT_TRUE(holds(finer));
  Drop lower;
  lower.height = 0.0075;
  EXPECT_THAT(thin_warnings(lower), IsEmpty());
  EXPECT_TRUE(holds(lower));
}

TEST(ThinContacts, OnlyWhatFallsOntoSomethingThinIsNamed) {
  Drop beside;  // upright it is thick along its fall
  beside.turn = Quaternion(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX()));
  beside.half = 0.05;
  EXPECT_THAT(thin_warnings(beside), IsEmpty());
  std::vector<Object> objects = {
      test::object("board", Box{Vec3(0.1, 0.1, 0.0005)}, {.stiffness = 1000}, {1, 0, 0.05}),
      test::object("floor", Plane{}, {.stiffness = 1000}),
      test::object("plate", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.3})};
  EXPECT_THAT(
      test::moving(objects, {-1, -1, 0}, {test::body("plate", 0.1, {0, 0, 0.3})}).warnings(),
      IsEmpty());
  // In a scene without weight nothing falls.
  objects[0].pose.position.x() = 0.0;
  EXPECT_THAT(
      test::moving(objects, {-1, -1, 0}, {test::body("plate", 0.1, {0, 0, 0.3})}, test::kWeightless)
          .warnings(),
      IsEmpty());
}

TEST(ThinContacts, PlatesThatFallOntoEachOtherCount) {
  std::vector<Object> objects = {
      test::object("floor", Plane{}, {.stiffness = 1000}),
      test::object("lower", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.3}),
      test::object("upper", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.31})};
  const Scene scene = test::moving(
      objects, {-1, 0, 1}, {test::body("a", 0.1, {0, 0, 0.3}), test::body("b", 0.1, {0, 0, 0.31})});
  EXPECT_THAT(scene.warnings(), SizeIs(1));
  EXPECT_THAT(scene.warnings(),
              ::testing::Contains(HasSubstr("'upper' (1 mm thick) falls 0.308 m onto 'lower'")));
}

}  // namespace
}  // namespace feltwire::thin_contacts_test
