// A robot of the C interface, and a hand that leads it, against a server of this process.

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <thread>
#include <utility>

#include "client/c_api/feltwire.h"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/client/c_api/heap_uses.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_test {
namespace {

using ::testing::HasSubstr;

constexpr std::uint32_t kReady = 1, kEngaged = 2, kFault = 5;  // states between hand and robot
constexpr double kRobotStart = 0.01;                           // [m] above its floor
constexpr double kHandStart = 0.3;                             // [m] above the floor of the scene

Scene scene_with_seat() {
  Scene scene = testing::floor_scene();
  scene.set_seats({RemoteSeat{}});
  return scene;
}

/// A mass over a floor, which an impedance controller draws to its target along z. A thread moves
/// it, and exchanges its state for targets, as a program would.
class Robot {
 public:
  static constexpr double kStiffness = 1000.0, kFloor = 2000.0;  // [N/m]

  explicit Robot(fw_follower* follower)
      : follower_(follower), thread_([this](const std::stop_token& end) { run(end); }) {}

  double height() const { return height_.load(); }  // [m]
  double force() const { return force_.load(); }    // [N] of the floor
  double opening() const { return opening_.load(); }
  bool has_ended() const { return ended_.load(); }
  void be_silent(bool silent) { silent_.store(silent); }
  void stop_for_its_people(bool stopped) { condition_.store(stopped ? 1 : 0); }

 private:
  void run(const std::stop_token& end) {
    fw_robot_state state;
    fw_robot_state_default(&state, sizeof state);
    fw_robot_target target{};
    state.commanded_position[2] = kRobotStart;
    state.has_force = 1;
    auto last = std::chrono::steady_clock::now();
    while (!end.stop_requested() && !ended_.load()) {
      const auto now = std::chrono::steady_clock::now();
      move(std::chrono::duration<double>(now - last).count(), state.commanded_position[2]);
      last = now;
      state.position[2] = height_.load();
      state.velocity[2] = velocity_;
      state.force[2] = force_.load();
      state.condition = condition_.load();
      if (!silent_.load()) {
        const std::int32_t result = fw_follower_exchange(follower_, &state, &target, sizeof target);
        EXPECT_GE(result, FW_OK) << fw_last_error();
        if (result == FW_OK) {
          std::ranges::copy(target.position, state.commanded_position);
          std::ranges::copy(target.orientation, state.commanded_orientation);
          state.gripper = target.gripper;
          opening_.store(target.gripper);
        }
        ended_.store(result == FW_ENDED);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void move(double time, double target) {
    constexpr double kMass = 2.0, kDamping = 90.0, kStep = 1e-4, kLongest = 0.05;
    double z = height_.load();
    for (double left = std::min(time, kLongest); left > 0.0; left -= kStep) {
      force_.store(std::max(0.0, -kFloor * z));
      const double pull = kStiffness * (target - z) - kDamping * velocity_ + force_.load();
      velocity_ += kStep * pull / kMass;
      z += kStep * velocity_;
    }
    height_.store(z);
  }

  fw_follower* follower_;
  std::atomic<double> height_{kRobotStart}, force_{0.0}, opening_{0.0};
  std::atomic<bool> silent_{false}, ended_{false};
  std::atomic<std::uint32_t> condition_{0};
  double velocity_ = 0.0;
  std::jthread thread_;  // the last member: it uses the others
};

class FollowerApi : public ::testing::Test {
 protected:
  fw_follower_options follower_options() const {
    fw_follower_options options;
    fw_follower_options_default(&options, sizeof options);
    server_.set_access(options);
    options.token_file = token_file_.c_str();
    options.scene = "floor";
    options.stiffness = Robot::kStiffness;
    options.gripper_opening = 0.08;
    return options;
  }
  fw_follower* follow() const {
    const fw_follower_options options = follower_options();
    fw_follower* follower = nullptr;
    EXPECT_EQ(fw_follower_open(&options, &follower), FW_OK) << fw_last_error();
    return follower;
  }
  /// A hand that the program moves, and that leads the robot. The thread of the test may wait.
  fw_hand* lead() const {
    static constexpr std::array<const char*, 8> kLeading = {
        "--flight-recorder", "off", "--let-go-after", "1", "--hold-time", "1", "--lead", "0.2"};
    fw_hand_options options = server_.hand_options();
    options.device = "caller:await_still=0";
    options.stale_after = 0.2;
    options.more = kLeading.data();
    options.more_count = static_cast<std::uint32_t>(kLeading.size());
    fw_hand* hand = nullptr;
    EXPECT_EQ(fw_hand_open(&options, &hand), FW_OK) << fw_last_error();
    return hand;
  }
  static fw_tick hold(fw_hand* hand, double z, bool deadman, double gripper = -1.0) {
    fw_pose pose;
    fw_pose_default(&pose, sizeof pose);
    pose.position[2] = z;
    pose.deadman = deadman ? 1 : 0;
    pose.gripper = gripper;
    fw_tick tick{};
    EXPECT_GE(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_OK) << fw_last_error();
    return tick;
  }
  static fw_robot_target target_of(const fw_follower* follower) {
    fw_robot_target target{};
    fw_follower_latest(follower, &target, sizeof target);
    return target;
  }
  /// Shows a released switch, then presses it.
  static void engage(fw_hand* hand, double z) {
    test::eventually("ready", [&] { return hold(hand, z, false).lead_state == kReady; });
    test::eventually("engaged", [&] { return hold(hand, z, true).lead_state == kEngaged; });
  }
  /// Lowers the hand until a condition holds, at the pace of a person: a robot does not follow a
  /// jump. A machine that lets the hand wait makes one; then the switch is released and pressed
  /// again. Returns the hand's height.
  template <class Condition>
  static double lower(fw_hand* hand, double from, const char* what, Condition condition,
                      double gripper = -1.0) {
    constexpr double kStep = 2e-5, kLowest = kHandStart - 0.03;  // [m]
    double z = from;
    bool pressed = true;
    test::eventually(what, [&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const fw_tick tick = hold(hand, z, pressed, gripper);
      pressed = tick.lead_state == kReady || tick.lead_state == kEngaged;
      if (tick.lead_state == kEngaged) z = std::max(z - kStep, kLowest);
      return condition(tick);
    });
    return z;
  }
  static bool feels_wall(const fw_tick& tick) { return tick.force[2] > 0.5; }

  IssuedToken token_ = issue_token("robot", "floor", Role::follower, std::nullopt);
  ApiServer server_{scene_with_seat(), {token_.token}};
  std::string token_file_ = server_.write_token("robot", token_);
};

// A real-time thread may call these.
TEST_F(FollowerApi, StatesAndTargetsAreExchangedWithoutTheHeap) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate";
#endif
  fw_follower* follower = follow();
  ASSERT_NE(follower, nullptr);
  fw_robot_state state;
  fw_robot_state_default(&state, sizeof state);
  fw_robot_target target{};
  const auto exchange = [&] {
    return fw_follower_exchange(follower, &state, &target, sizeof target);
  };
  test::eventually("a target", [&] { return exchange() == FW_OK; });
  EXPECT_EQ(test::uses_of_heap(exchange), 0u);
  EXPECT_EQ(
      test::uses_of_heap([&] { return fw_follower_latest(follower, &target, sizeof target); }), 0u);
  EXPECT_EQ(fw_follower_close(follower), FW_OK) << fw_last_error();
}

TEST_F(FollowerApi, TheRobotFollowsAndTheHandFeelsItsWall) {
  fw_follower* follower = follow();
  ASSERT_NE(follower, nullptr);
  fw_robot_target target{};
  EXPECT_EQ(fw_follower_latest(follower, &target, sizeof target), FW_NOTHING);
  {
    const Robot robot(follower);
    test::eventually("a target", [&] { return target_of(follower).number > 0; });
    EXPECT_NEAR(target_of(follower).position[2], kRobotStart, 1e-6) << "it stays";
    EXPECT_EQ(target_of(follower).connected, 1u);
    fw_hand* hand = lead();
    ASSERT_NE(hand, nullptr);
    engage(hand, kHandStart);
    EXPECT_STREQ(fw_lead_state_text(kEngaged), "engaged");
    EXPECT_STREQ(fw_lead_state_text(99), "");
    constexpr double kOpen = 0.05;  // [m]
    const double z = lower(
        hand, kHandStart, "the robot follows",
        [&](const fw_tick&) { return robot.height() < kRobotStart / 2; }, kOpen);
    EXPECT_GT(robot.height(), 0.0);
    EXPECT_GT(target_of(follower).sample, 0u);
    EXPECT_GE(target_of(follower).age, 0.0);
    test::eventually("the gripper", [&] {
      hold(hand, z, true, kOpen);
      return std::abs(robot.opening() - kOpen) < 1e-6;
    });
    const double deep = lower(hand, z, "the wall of the robot", feels_wall);
    lower(hand, deep, "the robot presses its floor",
          [&](const fw_tick&) { return robot.force() > 0.5; });
    EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
    EXPECT_EQ(fw_follower_stop(follower), FW_OK);
    test::eventually("its end", [&] { return robot.has_ended(); });
  }
  EXPECT_EQ(fw_follower_wait(follower, 0.0), FW_ENDED);
  EXPECT_EQ(target_of(follower).connected, 0u);
  EXPECT_EQ(fw_follower_close(follower), FW_OK) << fw_last_error();
}

TEST_F(FollowerApi, ARobotThatFallsSilentIsLedNoMoreAndTheHandIsTold) {
  fw_follower* follower = follow();
  ASSERT_NE(follower, nullptr);
  {
    Robot robot(follower);
    fw_hand* hand = lead();
    ASSERT_NE(hand, nullptr);
    engage(hand, kHandStart);
    const double z = lower(hand, kHandStart, "the wall of the robot", feels_wall);
    robot.be_silent(true);
    fw_tick tick{};
    test::eventually("no force, and the hand knows why", [&] {
      tick = hold(hand, z, true);
      return tick.lead_state == kFault && tick.force[2] == 0.0;
    });
    EXPECT_EQ(tick.connected, 1u) << "its own session goes on";
    const double stands = target_of(follower).position[2];
    for (int i = 0; i < 50; ++i) {
      hold(hand, z + 0.01, true);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(target_of(follower).position[2], stands) << "a silent robot gets no other target";
    // The robot is heard again. It is led again only after the switch was released.
    robot.be_silent(false);
    test::eventually("another command", [&] {
      hold(hand, z + 0.01, true);
      return target_of(follower).age < 0.05;
    });
    EXPECT_EQ(hold(hand, z + 0.01, true).lead_state, kFault);
    engage(hand, z + 0.01);
    robot.stop_for_its_people(true);
    test::eventually("a protective stop",
                     [&] { return hold(hand, z + 0.01, true).lead_state == kFault; });
    EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  }
  EXPECT_EQ(fw_follower_close(follower), FW_OK) << fw_last_error();
}

TEST_F(FollowerApi, OptionsAndStatesThatAreWrongAreNamed) {
  fw_follower* follower = nullptr;
  const auto refused = [&](auto change, std::int32_t result, const char* text) {
    fw_follower_options options = follower_options();
    change(options);
    EXPECT_EQ(fw_follower_open(&options, &follower), result);
    EXPECT_THAT(fw_last_error(), HasSubstr(text));
    EXPECT_EQ(follower, nullptr);
  };
  using Options = fw_follower_options;
  refused([](Options& o) { o.stiffness = 0.0; }, FW_ERROR_ARGUMENT, "options.stiffness must be");
  refused([](Options& o) { o.period = 0.1; }, FW_ERROR_ARGUMENT, "options.period must be");
  refused([](Options& o) { o.scene = nullptr; }, FW_ERROR_ARGUMENT, "options.scene is null");
  refused([](Options& o) { o.scene = "\xff"; }, FW_ERROR_ARGUMENT, "options.scene is not text");
  refused([](Options& o) { o.name = "\xff"; }, FW_ERROR_ARGUMENT, "options.name is not text");
  refused([](Options& o) { o.seat = "\xff"; }, FW_ERROR_ARGUMENT, "options.seat is not text");
  refused([](Options& o) { o.robot = "\xff"; }, FW_ERROR_ARGUMENT, "options.robot is not text");
  refused([](Options& o) { o.locked = 16; }, FW_ERROR_ARGUMENT, "options.locked has bits");
  refused([](Options& o) { o.speed = -1.0; }, FW_ERROR_ARGUMENT, "speed limit");
  refused([](Options& o) { o.workspace_low[0] = 1.0; }, FW_ERROR_ARGUMENT, "workspace_low must be");
  refused([](Options& o) { o.seat = "sofa"; }, FW_ERROR_REFUSED, "sofa");
  refused([&](Options& o) { o.token_file = server_.token_file.c_str(); }, FW_ERROR_REFUSED,
          "does not join as follower");
  EXPECT_EQ(fw_follower_open(nullptr, &follower), FW_ERROR_ARGUMENT);

  follower = follow();
  ASSERT_NE(follower, nullptr);
  fw_robot_target target{};
  const auto impossible = [&](auto change, const char* text) {
    fw_robot_state state;
    fw_robot_state_default(&state, sizeof state);
    change(state);
    EXPECT_EQ(fw_follower_exchange(follower, &state, &target, sizeof target), FW_ERROR_ARGUMENT);
    EXPECT_THAT(fw_last_error(), HasSubstr(text));
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  using State = fw_robot_state;
  impossible([](State& s) { s.position[1] = kNone; }, "state.position is not");
  impossible([](State& s) { s.orientation[0] = 0.5; }, "state.orientation is no");
  impossible([](State& s) { s.commanded_position[0] = 2e3; }, "state.commanded_position is not");
  impossible([](State& s) { s.has_force = 1, s.force[0] = kNone; }, "state.force is not");
  impossible([](State& s) { s.gripper = -1.0; }, "state.gripper must be");
  impossible([](State& s) { s.condition = 3; }, "state.condition must be");
  EXPECT_EQ(fw_follower_latest(follower, &target, sizeof target), FW_NOTHING) << "none was taken";
  EXPECT_EQ(fw_follower_close(follower), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_follower_close(nullptr), FW_OK);
}

TEST_F(FollowerApi, AServerThatEndsEndsTheFollower) {
  fw_follower_options options = follower_options();
  options.patience = 0.0;
  fw_follower* follower = nullptr;
  ASSERT_EQ(fw_follower_open(&options, &follower), FW_OK) << fw_last_error();
  server_.server.reset();
  EXPECT_EQ(fw_follower_wait(follower, 60.0), FW_ENDED);
  std::array<char, 256> text{};
  EXPECT_EQ(fw_follower_message(follower, text.data(), text.size()), FW_OK);
  EXPECT_THAT(text.data(), HasSubstr("the robot stays at its place"));
  EXPECT_EQ(fw_follower_message(follower, text.data(), text.size()), FW_NOTHING);
  EXPECT_EQ(fw_follower_close(follower), FW_ENDED);
  EXPECT_THAT(fw_last_error(), HasSubstr("server"));
}

TEST_F(FollowerApi, APoseOfAnOlderProgramHasNoGripper) {
  fw_hand* hand = lead();
  ASSERT_NE(hand, nullptr);
  fw_pose pose;
  fw_pose_default(&pose, sizeof pose);
  pose.position[2] = kHandStart;
  pose.gripper = std::numeric_limits<double>::quiet_NaN();
  fw_tick tick{};
  EXPECT_EQ(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("pose.gripper is not a number"));
  pose.struct_size = offsetof(fw_pose, gripper);
  EXPECT_GE(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

}  // namespace
}  // namespace feltwire::c_api_test
