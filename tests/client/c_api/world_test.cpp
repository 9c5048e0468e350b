// A hand of the C interface in the physics of the program.

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "client/c_api/feltwire.h"
#include "tests/client/c_api/heap_uses.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_world_test {
namespace {

using ::testing::HasSubstr;

constexpr double kStiffness = 1000.0;  // [N/m]

class CApiWorld : public ::testing::Test {
 protected:
  ~CApiWorld() override { fw_hand_close(hand_); }

  static fw_world_options options() {
    fw_world_options options;
    fw_world_options_default(&options, sizeof options);
    options.stiffness = kStiffness;
    options.more = kMore.data();
    options.more_count = static_cast<std::uint32_t>(kMore.size());
    return options;
  }
  void open(const fw_world_options& given) {
    ASSERT_EQ(fw_hand_open_world(&given, &hand_), FW_OK) << fw_last_error();
    test::eventually("a tick", [&] { return tick().number > 0; });
  }
  fw_tick tick() const {
    fw_tick tick{};
    fw_hand_latest(hand_, &tick, sizeof tick);
    return tick;
  }
  static fw_patch floor() {
    fw_patch patch;
    fw_patch_default(&patch, sizeof patch);
    patch.stiffness = kStiffness;
    return patch;
  }
  std::int32_t touch(const fw_patch& patch) {
    return fw_hand_touch(hand_, tick().time, 0.1, &patch, sizeof patch, 1);
  }

  // A busy machine may let the threads of this test wait.
  static constexpr std::array<const char*, 4> kMore = {"--let-go-after", "1", "--hold-time", "1"};
  fw_hand* hand_ = nullptr;
};

TEST_F(CApiWorld, AHandFeelsTheSurfacesOfTheProgram) {
  open(options());
  fw_tick felt{};
  test::eventually("the floor pushes", [&] {
    EXPECT_GE(touch(floor()), FW_OK) << fw_last_error();
    felt = tick();
    return felt.force[2] > 0.5;
  });
  EXPECT_LT(felt.position[2], 0.0);
  EXPECT_EQ(fw_hand_stop(hand_), FW_OK);
  EXPECT_EQ(fw_hand_wait(hand_, 20.0), FW_ENDED);
  EXPECT_EQ(touch(floor()), FW_ENDED);
  EXPECT_EQ(fw_hand_close(hand_), FW_OK) << fw_last_error();
  hand_ = nullptr;
}

TEST_F(CApiWorld, PhysicsThatStopsIsNotFeltForLong) {
  open(options());
  test::eventually("the floor pushes", [&] {
    touch(floor());
    return tick().force[2] > 0.5;
  });
  test::eventually("the force has faded", [&] { return tick().force[2] == 0.0; });
}

TEST_F(CApiWorld, AForceWithAStiffnessIsFelt) {
  open(options());
  test::eventually("the spring pushes", [&] {
    const fw_tick now = tick();
    fw_wrench wrench;
    fw_wrench_default(&wrench, sizeof wrench);
    wrench.time = now.time;
    wrench.force[2] = kStiffness * std::max(0.0, -now.position[2]);
    wrench.stiffness = kStiffness;
    EXPECT_GE(fw_hand_push(hand_, &wrench), FW_OK) << fw_last_error();
    return now.force[2] > 0.5;
  });
}

// A simulator that is out of its mind gives 9 kN, as the force of a spring and as a force alone.
// The hand gets what the limits and the account leave.
TEST_F(CApiWorld, APushOfNineKilonewtonsGivesNoMoreThanTheLimit) {
  constexpr double kLimit = 3.0, kPush = 9000.0;  // [N]
  static constexpr std::array<const char*, 6> kLimited = {"--let-go-after", "1", "--hold-time", "1",
                                                          "--max-force",    "3"};
  fw_world_options given = options();
  given.more = kLimited.data();
  given.more_count = kLimited.size();
  for (const double stiffness : {kStiffness, 0.0}) {
    open(given);
    double most = 0.0;
    std::uint64_t pushed = 0;  // ticks
    test::eventually("300 ticks of that push", [&] {
      fw_wrench wrench;
      fw_wrench_default(&wrench, sizeof wrench);
      wrench.time = tick().time;
      wrench.force[2] = kPush;
      wrench.stiffness = stiffness;
      EXPECT_GE(fw_hand_push(hand_, &wrench), FW_OK) << fw_last_error();
      std::array<fw_tick, 64> ticks{};
      std::uint32_t count = 0;
      fw_hand_ticks(hand_, ticks.data(), sizeof(fw_tick), ticks.size(), &count);
      for (std::uint32_t i = 0; i < count; ++i) {
        const fw_tick& one = ticks[i];
        pushed += one.scene_force[2] > kPush / 2 ? 1 : 0;
        most = std::max(most, std::hypot(one.force[0], one.force[1], one.force[2]));
      }
      return pushed >= 300 && (most > 0.0 || stiffness == 0.0);
    });
    EXPECT_LE(most, kLimit + 1e-9) << "with a stiffness of " << stiffness;
    EXPECT_EQ(fw_hand_close(std::exchange(hand_, nullptr)), FW_OK) << fw_last_error();
  }
}

// These calls may be made from a real-time thread.
TEST_F(CApiWorld, WhatTheHandTouchesIsToldWithoutTheHeap) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate";
#endif
  open(options());
  const std::array<fw_patch, 3> patches = {floor(), floor(), floor()};
  fw_wrench wrench;
  fw_wrench_default(&wrench, sizeof wrench);
  EXPECT_EQ(test::uses_of_heap([&] {
              return fw_hand_touch(hand_, tick().time, 0.1, patches.data(), sizeof(fw_patch), 3);
            }),
            0u);
  EXPECT_EQ(test::uses_of_heap([&] {
              wrench.time = tick().time;
              return fw_hand_push(hand_, &wrench);
            }),
            0u);
}

TEST_F(CApiWorld, WrongPatchesAreNamed) {
  open(options());
  const auto refused = [&](auto change, const char* why) {
    fw_patch patch = floor();
    change(patch);
    EXPECT_EQ(touch(patch), FW_ERROR_ARGUMENT);
    EXPECT_THAT(fw_last_error(), HasSubstr(why));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused([](fw_patch& p) { p.point[1] = kNan; }, "patches[0].point");
  refused([](fw_patch& p) { p.normal[2] = 2.0; }, "patches[0].normal");
  refused([](fw_patch& p) { p.normal[0] = kNan; }, "patches[0].normal");
  refused([](fw_patch& p) { p.axis[0] = 0.5; }, "patches[0].axis");
  refused([](fw_patch& p) { p.axis[2] = 1.0; }, "axis is not across the normal");
  refused([](fw_patch& p) { p.curvature = 1e300; }, "patches[0].curvature");
  refused([](fw_patch& p) { p.stiffness = 1e-300; }, "patches[0].stiffness");
  refused([](fw_patch& p) { p.velocity[0] = kNan; }, "patches[0].velocity");
  refused([](fw_patch& p) { p.curvature = kNan; }, "patches[0].curvature");
  refused([](fw_patch& p) { p.radius = kNan; }, "patches[0].radius");
  refused([](fw_patch& p) { p.stiffness = 0.0; }, "patches[0].stiffness");
  refused([](fw_patch& p) { p.stiffness = kNan; }, "patches[0].stiffness");
  refused([](fw_patch& p) { p.damping = -1.0; }, "patches[0].damping");
  refused([](fw_patch& p) { p.dynamic_friction = 0.5; }, "patches[0].dynamic_friction");
  refused([](fw_patch& p) { p.viscous_friction = kNan; }, "patches[0].viscous_friction");
  refused([](fw_patch& p) { p.object = 70000; }, "patches[0].object");
  const fw_patch patch = floor();
  const auto call = [&](double time, double reach, const fw_patch* patches, std::uint32_t size,
                        std::uint32_t count, const char* why) {
    EXPECT_EQ(fw_hand_touch(hand_, time, reach, patches, size, count), FW_ERROR_ARGUMENT);
    EXPECT_THAT(fw_last_error(), HasSubstr(why));
  };
  call(kNan, 0.1, &patch, sizeof patch, 1, "time");
  call(-1.0, 0.1, &patch, sizeof patch, 1, "time");
  call(1e9, 0.1, &patch, sizeof patch, 1, "time is later than the newest tick");
  call(0.0, kNan, &patch, sizeof patch, 1, "reach");
  call(0.0, 2.0, &patch, sizeof patch, 1, "reach");
  call(0.0, 0.1, nullptr, sizeof patch, 1, "patches is null");
  call(0.0, 0.1, &patch, 3, 1, "struct_size");
  call(0.0, 0.1, &patch, sizeof patch, 4, "at most 3");
  fw_wrench wrench;
  fw_wrench_default(&wrench, sizeof wrench);
  wrench.force[0] = kNan;
  EXPECT_EQ(fw_hand_push(hand_, &wrench), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("wrench.force"));
  EXPECT_EQ(fw_hand_push(hand_, nullptr), FW_ERROR_ARGUMENT);
}

// Numbers that a program rounds are taken, and felt.
TEST_F(CApiWorld, ANormalThatIsAlmostUnitIsFelt) {
  open(options());
  test::eventually("the floor pushes", [&] {
    fw_patch patch = floor();
    patch.normal[2] = 1.0009;
    patch.axis[0] = 0.9991;
    EXPECT_GE(touch(patch), FW_OK) << fw_last_error();
    return tick().force[2] > 0.5;
  });
}

TEST_F(CApiWorld, AnAnswerToAnOldPoseIsNotTaken) {
  open(options());
  const fw_patch patch = floor();
  test::eventually("a tick after the hold time", [&] { return tick().time > 1.1; });
  EXPECT_EQ(fw_hand_touch(hand_, 0.0, 0.1, &patch, sizeof patch, 1), FW_NOTHING);
  const double newest = tick().time;
  EXPECT_EQ(fw_hand_touch(hand_, newest, 0.1, &patch, sizeof patch, 1), FW_OK);
  EXPECT_EQ(fw_hand_touch(hand_, newest - 0.001, 0.1, &patch, sizeof patch, 1), FW_NOTHING);
}

TEST_F(CApiWorld, WrongOptionsAreNamed) {
  const auto refused = [&](auto change, const char* why) {
    fw_world_options given = options();
    change(given);
    EXPECT_EQ(fw_hand_open_world(&given, &hand_), FW_ERROR_ARGUMENT);
    EXPECT_EQ(hand_, nullptr);
    EXPECT_THAT(fw_last_error(), HasSubstr(why));
  };
  refused([](fw_world_options& o) { o.stiffness = 0.0; }, "stiffness");
  refused([](fw_world_options& o) { o.start_normal[2] = 0.0; }, "start_normal");
  refused([](fw_world_options& o) { o.name = "\xff"; }, "--name: the name is not text in UTF-8");
  refused([](fw_world_options& o) { o.struct_size = 0; }, "world_options.struct_size");
  static constexpr std::array<const char*, 2> kLink = {"--link", "wifi"};
  refused(
      [](fw_world_options& o) {
        o.more = kLink.data();
        o.more_count = kLink.size();
      },
      "--link");
  static constexpr std::array<const char*, 2> kServer = {"--mode", "side=server"};
  refused(
      [](fw_world_options& o) {
        o.more = kServer.data();
        o.more_count = kServer.size();
      },
      "side of --mode must be client");
  static constexpr std::array<const char*, 2> kOther = {"--connect", "elsewhere:1"};
  refused(
      [](fw_world_options& o) {
        o.more = kOther.data();
        o.more_count = kOther.size();
      },
      "--connect");
  // A person may hold what a program or a plugin moves.
  for (const char* law : {"none", "per_axis,account=off"}) {
    const std::array<const char*, 2> without_account = {"--mode", law};
    refused(
        [&](fw_world_options& o) {
          o.device = "caller";
          o.more = without_account.data();
          o.more_count = without_account.size();
        },
        "without an energy account, and a person may hold this device");
  }
  EXPECT_EQ(fw_hand_open_world(nullptr, &hand_), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_hand_touch(nullptr, 0.0, 0.1, nullptr, 0, 0), FW_ERROR_ARGUMENT);
}

// The program's header is older than the library: it knows a patch up to its stiffness.
TEST_F(CApiWorld, AnOlderPatchIsRead) {
  open(options());
  std::array<fw_patch, 1> patch = {floor()};
  const std::uint32_t size = offsetof(fw_patch, curvature);
  EXPECT_GE(fw_hand_touch(hand_, tick().time, 0.1, patch.data(), size, 1), FW_OK)
      << fw_last_error();
}

TEST_F(CApiWorld, ANewerPatchWithAFieldThatIsNotKnownIsRefused) {
  open(options());
  struct {
    fw_patch patch;
    double later;
  } given{floor(), 0.0};
  const auto touch_newer = [&] {
    return fw_hand_touch(hand_, tick().time, 0.1, &given.patch, sizeof given, 1);
  };
  EXPECT_GE(touch_newer(), FW_OK) << fw_last_error();
  given.later = 5.0;
  EXPECT_EQ(touch_newer(), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("does not know"));
}

}  // namespace
}  // namespace feltwire::c_api_world_test
