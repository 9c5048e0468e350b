// Thin bodies fall onto thin bodies. Tests the loader's warnings and the simulation.
#include "core/dynamics/thin_contacts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/moving.hpp"
#include "tests/core/support.hpp"

namespace feltwire::thin_contacts_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kGravity = 9.81;

struct Drop {
  Shape shape = Box{Vec3(0.05, 0.05, 0.0005)};
  double half = 0.0005;  // [m] half of the plate's thickness
  double board = 0.001;  // [m] thickness
  double height = 0.25;  // [m] from the board to the plate's lowest point
  double tick = 1e-3;    // [s]
  Quaternion turn = Quaternion::Identity();
};

Scene scene_of(const Drop& drop) {
  std::vector<Object> objects = {test::object("board", Box{Vec3(0.15, 0.15, 0.5 * drop.board)},
                                              {.stiffness = 1000}, {0, 0, 0.05 - 0.5 * drop.board}),
                                 test::object("floor", Plane{}, {.stiffness = 1000}),
                                 test::object("plate", drop.shape, {.stiffness = 1000},
                                              {0, 0, 0.05 + drop.height + drop.half})};
  objects[2].pose.orientation = drop.turn;
  return test::moving(std::move(objects), {-1, -1, 0},
                      {test::body("plate", 0.1, {0, 0, 0.05 + drop.height + drop.half})},
                      {.tick = drop.tick});
}

/// Returns true if the plate lies on the board after the fall, or has left it over the edge.
bool holds(const Drop& drop) {
  const Scene scene = scene_of(drop);
  World world(scene);
  const double until = std::sqrt(2.0 * drop.height / kGravity) + 0.7;
  for (double t = 0.0; t < until; t += drop.tick) {
    world.step();
    const Vec3 place = world.objects()[2].pose.position;
    if (std::hypot(place.x(), place.y()) > 0.08) return true;
    if (place.z() < 0.05 - drop.board) return false;
  }
  return true;
}

std::vector<std::string> fall_warnings(const Scene& scene) {
  std::vector<std::string> thin;
  for (const std::string& warning : scene.warnings())
    if (warning.find("may fall through") != std::string::npos) thin.push_back(warning);
  return thin;
}

std::vector<std::string> thin_warnings(const Drop& drop) { return fall_warnings(scene_of(drop)); }

TEST(ThinContacts, APlateThatFallsThroughABoardIsSaidWithNumbersAndRemedy) {
  Drop drop;
  // The start height decides whether a tick finds the plate in the board or beyond it.
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

std::vector<std::string> push_warnings(const Scene& scene) {
  std::vector<std::string> pushed;
  for (const std::string& warning : scene.warnings())
    if (warning.find("may push it through the other") != std::string::npos)
      pushed.push_back(warning);
  return pushed;
}

/// A hand pushes the plate down onto the board, with this speed [m/s] and at most 40 N, to this
/// depth [m] below the plate's place on the board. Returns whether the plate is pushed through.
bool is_pushed_through(const Drop& drop, double speed, double depth) {
  const Scene scene = scene_of(drop);
  World world(scene);
  TouchMemory memory = world.view().memory();
  BodyContactState contacts = world.contact_state(world.view(), {.force = 40.0});
  double hand = 0.05 + drop.height + 2.0 * drop.half + 1e-3;
  for (double t = 0.0; t < 0.5; t += drop.tick) {
    hand = std::max(0.05 + 2.0 * drop.half - depth, hand - speed * drop.tick);
    world.touch({Vec3(0, 0, hand), Vec3::Zero()}, memory, contacts);
    world.push(contacts, memory, 1.0);
    world.step();
    if (world.objects()[2].pose.position.z() < 0.05 - drop.board) return true;
  }
  return false;
}

TEST(ThinContacts, APlateThatAHandCanPushThroughABoardIsSaid) {
  const Drop drop{.board = 0.003, .height = 0.02};
  EXPECT_THAT(thin_warnings(drop), IsEmpty());  // its fall is too slow
  EXPECT_THAT(push_warnings(scene_of(drop)),
              ::testing::ElementsAre(AllOf(
                  HasSubstr("objects 'plate' (1 mm thick) and 'board' (3 mm thick): with a tick of "
                            "1 ms they hold each other up to 0.803 m/s"),
                  HasSubstr("at least 4.98 mm thick together"), HasSubstr("a tick of at most"))));
  // A longer fall makes the plate as fast as a push would. The start decides whether it passes.
  int passed = 0;
  for (int i = 0; i < 16; ++i)
    passed += holds({.board = 0.003, .height = 0.5 + 0.0003 * i}) ? 0 : 1;
  EXPECT_GT(passed, 0);
}

TEST(ThinContacts, BodiesThatHoldAHandAreNotSaid) {
  for (const double thick : {0.0025, 0.005, 0.02}) {
    const Drop drop{Box{Vec3(0.05, 0.05, 0.5 * thick)}, 0.5 * thick, thick, 0.01};
    EXPECT_THAT(push_warnings(scene_of(drop)), IsEmpty()) << thick;
    for (int i = 0; i < 8; ++i)
      EXPECT_FALSE(is_pushed_through({drop.shape, drop.half, thick, 0.01 + 0.0003 * i}, 0.9, 1e-3));
  }
}

/// Bodies without a warning must not fall through, for any shape, size, tick and height. Each
/// remedy must help.
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

/// Plates, coins and rods fall in every orientation. An edge lands first, then the rest. Cylinders
/// below 8 mm are excluded (docs/moving.md).
TEST(ThinContacts, WhatFallsOnAnEdgeAndIsNotWarnedOfHolds) {
  test::Random random(7);
  const auto between = [&](double least, double most) {
    return least * std::pow(most / least, random.uniform(0.0, 1.0));
  };
  int warned = 0, silent = 0, fell = 0;
  for (int i = 0; i < 400; ++i) {
    const double half = 0.5 * between(0.001, 0.008), wide = between(std::max(half, 0.004), 0.04),
                 long_ = between(std::max(half, 0.004), 0.04);
    Drop drop{.board = between(0.001, 0.03), .height = between(0.0005, 0.25)};
    drop.tick = i % 3 == 0 ? 3e-4 : 1e-3;
    const double tilt = i % 5 == 0 ? 0.5 * M_PI : random.uniform(0.0, 0.5 * M_PI);
    const double around = random.uniform(0.0, M_PI);
    drop.turn = Eigen::AngleAxisd(tilt, Vec3(std::cos(around), std::sin(around), 0));
    const Vec3 up = drop.turn.conjugate() * Vec3::UnitZ();
    switch (i % 4) {
      case 0:
        drop.shape = Box{Vec3(wide, long_, half)};
        drop.half = up.cwiseAbs().dot(Vec3(wide, long_, half));
        break;
      case 1:
        drop.shape = Cylinder{wide, half};
        drop.half = wide * std::hypot(up.x(), up.y()) + half * std::abs(up.z());
        break;
      case 2:
        drop.shape = Capsule{half, wide};
        drop.half = half + wide * std::abs(up.z());
        break;
      default:
        drop.shape = Cylinder{half, wide};
        drop.half = half * std::hypot(up.x(), up.y()) + wide * std::abs(up.z());
    }
    const bool held = holds(drop);
    if (!held) ++fell;
    if (!thin_warnings(drop).empty()) {
      ++warned;
      continue;
    }
    ++silent;
    EXPECT_TRUE(held) << i << ": " << half << " " << drop.board << " " << drop.height << " "
                      << drop.tick << " " << tilt;
  }
  EXPECT_GT(fell, 20);
  EXPECT_GT(warned, 60);
  EXPECT_GT(silent, 100);
}

TEST(ThinContacts, ARodIsLostInABoxOfAnyThickness) {
  Drop rod;
  rod.shape = Capsule{0.0005, 0.03};
  rod.half = 0.0305;
  rod.board = 0.04;
  EXPECT_THAT(thin_warnings(rod),
              ::testing::ElementsAre(HasSubstr("make the capsule at least 11.7 mm thick")));
  rod.turn = Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX());
  rod.half = 0.0005;
  rod.height = 1e-4;
  EXPECT_THAT(thin_warnings(rod), IsEmpty());
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
  Drop upright;  // The plate topples.
  upright.turn = Quaternion(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX()));
  upright.half = 0.05;
  upright.height = 0.0;
  EXPECT_THAT(thin_warnings(upright),
              ::testing::ElementsAre(HasSubstr("or lay it flat: it topples")));
  std::vector<Object> objects = {
      test::object("board", Box{Vec3(0.1, 0.1, 0.0005)}, {.stiffness = 1000}, {1, 0, 0.05}),
      test::object("floor", Plane{}, {.stiffness = 1000}),
      test::object("plate", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.3})};
  EXPECT_THAT(
      fall_warnings(test::moving(objects, {-1, -1, 0}, {test::body("plate", 0.1, {0, 0, 0.3})})),
      IsEmpty());
  // In a weightless scene nothing falls.
  objects[0].pose.position.x() = 0.0;
  EXPECT_THAT(
      fall_warnings(test::moving(objects, {-1, -1, 0}, {test::body("plate", 0.1, {0, 0, 0.3})},
                                 test::kWeightless)),
      IsEmpty());
}

TEST(ThinContacts, PlatesThatFallOntoEachOtherCount) {
  std::vector<Object> objects = {
      test::object("floor", Plane{}, {.stiffness = 1000}),
      test::object("lower", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.3}),
      test::object("upper", Box{Vec3(0.05, 0.05, 0.0005)}, {.stiffness = 1000}, {0, 0, 0.31})};
  const Scene scene = test::moving(
      objects, {-1, 0, 1}, {test::body("a", 0.1, {0, 0, 0.3}), test::body("b", 0.1, {0, 0, 0.31})});
  EXPECT_THAT(scene.warnings(), SizeIs(2));
  EXPECT_THAT(scene.warnings(),
              ::testing::Contains(HasSubstr("'upper' (1 mm thick) falls 0.308 m onto 'lower'")));
  EXPECT_THAT(push_warnings(scene), SizeIs(1));
}

}  // namespace
}  // namespace feltwire::thin_contacts_test
