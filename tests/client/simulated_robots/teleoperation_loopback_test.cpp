// Tests a complete server, a hand's servo loop and a robot's loop in one process, over real sockets
// of this machine.

#include <gmock/gmock.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/followers/follower_loop.hpp"
#include "client/servo/servo_loop.hpp"
#include "server/app/server.hpp"
#include "tests/client/simulated_robots/teleoperation_bench.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"

namespace feltwire::teleoperation_loopback_test {
namespace {

constexpr std::chrono::milliseconds kPatience{10'000};

/// Presses its switch, moves down by 35 mm, stays, returns, and releases the switch.
class ScriptedHand final : public HandDevice {
 public:
  ScriptedHand() : HandDevice(builtin_device("simulated"), {}) { place(kStart); }
  DeviceReading read(Nanoseconds now) noexcept override {
    DeviceReading reading = HandDevice::read(now);
    reading.deadman = time_ > 0.3 && time_ < 2.0;
    reading.ended = time_ > 2.3;
    return reading;
  }

 private:
  static constexpr double kDepth = 0.035;
  inline static const Vec3 kStart{0.05, 0.05, 0.05};
  Vec3 intended(double time) noexcept override {
    time_ = time;
    const double down = std::clamp((time - 0.5) / 0.5, 0.0, 1.0);
    const double up = std::clamp((time - 1.5) / 0.4, 0.0, 1.0);
    return kStart - kDepth * (down - up) * Vec3::UnitZ();
  }
  double time_ = 0.0;
};

ServerConfig any_ports() {
  ServerConfig config;
  config.port = 0;
  config.log.level = "off";
  return config;
}

std::vector<Scene> seat() {
  std::vector<Scene> scenes;
  scenes.push_back(test::empty_scene());
  return scenes;
}

TEST(TeleoperationLoopback, ARobotsTokenOpensNoOtherSeat) {
  const IssuedToken robot_token = issue_token("robot", "empty", Role::follower, std::nullopt);
  const IssuedToken hand_token = issue_token("anna", "*", Role::operator_, std::nullopt);
  Server server(any_ports(), seat(), test::security({robot_token.token, hand_token.token}));
  const ScriptedHand hand;
  const auto refused = [&](const IssuedToken& token, Role wanted) -> std::string {
    try {
      join(test::access(server.control_port(), "127.0.0.1", token.text),
           {"tester", "empty", hand.spec(), usual_parameters(), wanted}, kPatience);
    } catch (const LastingError& error) {
      return error.what();
    }
    return "no";
  };
  for (const Role other : {Role::operator_, Role::observer, Role::pointer, Role::admin})
    EXPECT_THAT(refused(robot_token, other), ::testing::HasSubstr("refused: ")) << name(other);
  EXPECT_THAT(refused(hand_token, Role::follower), ::testing::HasSubstr("refused: "));
  EXPECT_THAT(refused(test::admin_token(), Role::follower), ::testing::HasSubstr("refused: "));
  EXPECT_EQ(refused(robot_token, Role::follower), "no");
}

/// Runs a robot in its own thread.
struct SeatedRobot {
  SeatedRobot(std::uint16_t port, const Secret& token, double patience)
      : run{.server = test::access(port, "127.0.0.1", token),
            .scene = "empty",
            .patience = patience,
            .on_join = [this] { joins.fetch_add(1); }},
        thread([this] { result = run_follower(robot, run, stop); }) {}
  ~SeatedRobot() { finish(); }
  void await_join(int count) {
    test::eventually("the robot on its seat", [&] { return joins.load() >= count; });
  }
  void finish() {
    stop.store(true);
    if (thread.joinable()) thread.join();
  }
  PointRobot robot{test::wall_scene(), Vec3(0.0, 0.0, 0.02)};
  std::atomic<bool> stop{false};
  std::atomic<int> joins{0};
  FollowerResult result;
  FollowerRun run;
  std::thread thread;  // This is the last member, because the thread uses the other members.
};

TEST(TeleoperationLoopback, ARobotJoinsAgainAfterALostSession) {
  const IssuedToken token = issue_token("robot", "empty", Role::follower, std::nullopt);
  auto server = std::make_unique<Server>(any_ports(), seat(), test::security({token.token}));
  ServerConfig same_port = any_ports();
  same_port.port = server->control_port();
  SeatedRobot seated(server->control_port(), token.text, 60.0);
  seated.await_join(1);
  server.reset();
  server = std::make_unique<Server>(same_port, seat(), test::security({token.token}));
  seated.await_join(2);
  seated.finish();
  EXPECT_EQ(seated.result.end, FollowerEnd::requested);
  EXPECT_EQ(seated.result.sessions, 2u);
  EXPECT_EQ(seated.result.statistics.engagements, 0u);
}

TEST(TeleoperationLoopback, ARobotThatIsRefusedAtItsReturnEnds) {
  const IssuedToken token = issue_token("robot", "empty", Role::follower, std::nullopt);
  auto server = std::make_unique<Server>(any_ports(), seat(), test::security({token.token}));
  ServerConfig same_port = any_ports();
  same_port.port = server->control_port();
  SeatedRobot seated(server->control_port(), token.text, 60.0);
  seated.await_join(1);
  server.reset();
  // The new server does not accept the robot's token.
  server = std::make_unique<Server>(same_port, seat(), test::security());
  seated.thread.join();
  // The session ends by a goodbye. If the server stopped before the robot's first datagram, the
  // session ends by silence.
  EXPECT_NE(seated.result.end, FollowerEnd::requested);
  EXPECT_EQ(seated.result.sessions, 1u);
}

TEST(TeleoperationLoopback, AHandFeelsWhatARobotTouches) {
  IssuedToken hand_token = issue_token("anna", "*", Role::operator_, std::nullopt);
  IssuedToken robot_token = issue_token("robot", "empty", Role::follower, std::nullopt);
  std::vector<Scene> scenes;
  scenes.push_back(test::empty_scene());
  Server server(any_ports(), std::move(scenes),
                test::security({hand_token.token, robot_token.token}));

  std::atomic<bool> stop{false}, sits{false};
  PointRobot robot(test::wall_scene(), Vec3(0.0, 0.0, 0.02));
  FollowerResult followed;
  std::thread follower([&] {
    FollowerRun run{.server = test::access(server.control_port(), "127.0.0.1", robot_token.text),
                    .scene = "empty"};
    run.on_join = [&] {
      sits.store(true);
      sits.notify_all();
    };
    followed = run_follower(robot, run, stop);
  });
  sits.wait(false);

  ScriptedHand hand;
  const SessionParameters parameters = usual_parameters();
  ServoOptions options = protect_hand(parameters);
  options.leads = RemoteTrust{.per_contact = 0.0, .power = 0.0};
  const Joined joined = join(test::access(server.control_port(), "127.0.0.1", hand_token.text),
                             {"tester", "empty", hand.spec(), parameters}, kPatience);
  Transport transport({joined.datagrams, joined.accepted.session, joined.keys},
                      joined.accepted.parameters, false);
  Servo servo(hand.spec(), joined.accepted.parameters, options);
  const Event never;
  LoopResult result;
  run_servo_loop(hand, servo, transport, {.silence_timeout = kPatience}, never, {}, result);
  EXPECT_EQ(result.end, EndReason::device_ended);
  EXPECT_GE(servo.statistics().max_force, 1.0) << "the wall was felt";
  EXPECT_EQ(servo.port().violations(), 0u);
  EXPECT_EQ(servo.held().force().norm(), 0.0);

  stop.store(true);
  follower.join();
  EXPECT_EQ(followed.end, FollowerEnd::requested);
  EXPECT_EQ(followed.sessions, 1u);
  EXPECT_EQ(followed.statistics.engagements, followed.statistics.holds);
  EXPECT_GE(followed.statistics.engagements, 1u);
  EXPECT_GE(followed.statistics.largest_force, 1.0);
}

}  // namespace
}  // namespace feltwire::teleoperation_loopback_test
