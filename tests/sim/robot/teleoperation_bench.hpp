#pragma once
// A hand, a server and a robot, with an emulated link on either side of the server, by the test's
// clock: the servos of hand and robot make sealed datagrams, and the server's sessions answer them.

#include <netinet/in.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/devices/hand_device.hpp"
#include "client/emulated_link/link.hpp"
#include "client/followers/follower_servo.hpp"
#include "client/followers/robot_datagrams.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/datagram_session.hpp"
#include "server/scene/scene_sessions.hpp"
#include "sim/robot/point_robot.hpp"
#include "tests/protocol/sealed.hpp"

namespace feltwire::test {

/// A hand that means to be where it is told, and its switch.
class ToldHand final : public HandDevice {
 public:
  ToldHand() : HandDevice(builtin_device("simulated"), {}) {}
  Vec3 meant = Vec3::Zero();                 // [m]
  bool pressed = false;                      // the switch
  std::optional<double> gripper;             // [m] of its lever
  Quaternion turn = Quaternion::Identity();  // of its handle
  DeviceReading read(Nanoseconds now) noexcept override {
    DeviceReading reading = HandDevice::read(now);
    reading.pose.orientation = turn;
    reading.deadman = pressed;
    reading.gripper = gripper;
    return reading;
  }
  void put(const Vec3& at) {
    meant = at;
    place(at);
  }

 private:
  Vec3 intended(double /*time*/) noexcept override { return meant; }
};

/// What the server knows of: nothing near, and a seat for a robot.
inline Scene empty_scene(const RemoteSeat& seat = {}) {
  Object far_away;
  far_away.name = "far";
  far_away.shape = Sphere{0.1};
  far_away.pose.position = Vec3(0.0, 0.0, -50.0);
  far_away.material = {.stiffness = 1000.0};
  Scene scene("empty", {far_away});
  scene.set_remote(seat);
  return scene;
}

/// What the robot meets: a wall at z = 0.
inline std::shared_ptr<const Scene> wall_scene(double stiffness = 2000.0) {
  Object wall;
  wall.name = "wall";
  wall.shape = Plane{};
  wall.material = {.stiffness = stiffness, .damping = 2.0};
  return std::make_shared<const Scene>("wall", std::vector<Object>{wall});
}

/// A hand, its servo, and its link to the server.
struct HandSession {
  HandSession(std::uint64_t id, const std::string& link, std::uint64_t stream,
              const RemoteTrust& trust)
      : parameters(usual_parameters()),
        options([&] {
          ServoOptions o = protect_hand(parameters);
          o.leads = trust;
          return o;
        }()),
        servo(hand.spec(), parameters, options),
        hand_datagrams(id, keys(id), parameters, true),
        hand_link(parse_link(link), stream, 4096) {}

  void reach(SceneSessions& sessions, Nanoseconds now, DatagramBuffer& room) {
    while (const auto d = hand_link.up.leave(now))
      if (!hand_cut)
        if (const Bytes answer = sessions.receive(*d, hand_peer, now, room); !answer.empty())
          hand_link.down.enter(answer, now);
  }
  void hear(Nanoseconds now) {
    GoodbyeReason reason = GoodbyeReason::leaving;
    while (const auto d = hand_link.down.leave(now))
      if (!hand_cut && hand_datagrams.take(*d, reply, reason) == DatagramSession::Arrival::reply) {
        if (change_reply) change_reply(reply);
        servo.take(reply, now);
      }
  }
  void sample(Nanoseconds now) {
    const Sample* sample = servo.tick(hand, now);
    hand_link.up.enter(hand_datagrams.pack(*sample, {}, servo.lead()), now);
    fastest_fall = std::max(fastest_fall, force_before_ - force());
    force_before_ = force();
  }
  double force() const { return servo.held().force().z(); }  // [N] that pushes the hand up
  /// [J] that the hand got beyond what the device burned.
  double made() const { return -servo.port().least_margin(); }

  SessionParameters parameters;
  ServoOptions options;
  ToldHand hand;
  Servo servo;
  DatagramSession hand_datagrams;
  TwoWayLink hand_link;
  bool hand_cut = false;
  std::function<void(Reply&)> change_reply;  // what the server says instead
  double fastest_fall = 0.0;                 // [N] of the hand's force, from one tick to the next
  Peer hand_peer{.address = {}, .length = sizeof(sockaddr_in)};
  Reply reply;

 private:
  double force_before_ = 0.0;
};

/// Of any robot, whose clock may go wrong.
struct RobotSession : HandSession {
  static constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
  static constexpr Nanoseconds kStart = std::chrono::seconds(100);
  static constexpr std::uint64_t kHand = 0x700, kRobot = 0x800;

  explicit RobotSession(Follower& any_robot, const std::string& link = "delay=0",
                        const RemoteSeat& seat = {},
                        const RemoteTrust& trust = {.per_contact = 0.0, .power = 0.0})
      : HandSession(kHand, link, 0, trust),
        driven(any_robot),
        scene(empty_scene(seat)),
        server(std::make_unique<SceneSessions>(scene, std::chrono::seconds(2), 8)),
        follower(driven.spec()),
        robot_datagrams(kRobot, keys(kRobot)),
        robot_link(parse_link(link), 1, 4096) {
    hand.put(Vec3(0.1, -0.2, 0.3));
    commanded = driven.read(now).commanded;
    robot_due_ = now + from_seconds(driven.spec().servo_period);
    join(kHand, Role::operator_);
    join(kRobot, Role::follower);
  }

  control::Message ask_to_join(std::uint64_t id, Role role) {
    return server->answer(control::JoinRequest{"tester", "empty", hand.spec(), parameters, role},
                          id, keys(id), now);
  }
  void join(std::uint64_t id, Role role) {
    const control::Message answer = ask_to_join(id, role);
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
    if (role == Role::follower) follower.sit(std::get<control::JoinAccepted>(answer).workspace);
  }

  void tick() {
    now += kPeriod;
    reach(*server, now, room);
    for (HandSession* other : others) other->reach(*server, now, room);
    while (const auto d = robot_link.up.leave(now))
      if (!robot_cut) server->receive(*d, robot_peer, now, room);
    Peer to;
    if (const Bytes due = server->forward(now, to, room); !due.empty()) {
      EXPECT_EQ(to.length, robot_peer.length);
      robot_link.down.enter(due, now);
    }
    hear(now);
    for (HandSession* other : others) other->hear(now);
    while (const auto d = robot_link.down.leave(now))
      if (!robot_cut && robot_datagrams.take(*d, target, reason) == RobotDatagrams::Arrival::target)
        follower.take(target, robot_now());
    sample(now);
    for (HandSession* other : others) other->sample(now);
    for (; robot_due_ <= robot_now(); robot_due_ += from_seconds(driven.spec().servo_period)) {
      RobotState said = follower.tick(driven, robot_due_);
      if (lie) lie(said);
      robot_link.up.enter(robot_datagrams.pack(said), now);
      farthest_step =
          std::max(farthest_step, (said.commanded.position - commanded.position).norm());
      commanded = said.commanded;
    }
  }
  void run(double time) {
    for (double t = 0.0; t < time; t += 1e-3) tick();
  }
  /// The hand means to go by `way`, smoothly, within the time.
  void move(const Vec3& way, double time) {
    const Vec3 from = hand.meant;
    const int ticks = static_cast<int>(time / 1e-3);
    for (int i = 1; i <= ticks; ++i) {
      const double s = static_cast<double>(i) / ticks;
      hand.meant = from + (s * s * (3.0 - 2.0 * s)) * way;
      tick();
    }
  }
  void engage() {
    hand.pressed = false;
    run(0.3);
    hand.pressed = true;
    run(0.3);
  }

  /// By the robot's own clock.
  Nanoseconds robot_now() const {
    return now + Nanoseconds(std::llround(drift * static_cast<double>((now - kStart).count())));
  }
  LinkState state() const { return server->link_state(); }

  Follower& driven;
  double drift = 0.0;  // [s/s] that the robot's clock is fast by
  Scene scene;
  std::unique_ptr<SceneSessions> server;
  std::vector<HandSession*> others;  // more hands in the scene
  FollowerServo follower;
  RobotDatagrams robot_datagrams;
  TwoWayLink robot_link;
  bool robot_cut = false;
  std::function<void(RobotState&)> lie;  // what the robot says instead
  double farthest_step = 0.0;            // [m] of the target that the robot holds, in one tick
  Pose commanded;                        // that target
  Nanoseconds now = kStart;
  Peer robot_peer{.address = {}, .length = sizeof(sockaddr_in6)};
  DatagramBuffer room;
  RobotTarget target;
  GoodbyeReason reason = GoodbyeReason::leaving;

 private:
  Nanoseconds robot_due_{0};  // its next sample, by its clock
};

struct PointAtWall {
  PointRobot robot;
};

/// Of a point robot 20 mm before a wall.
struct Teleoperation : PointAtWall, RobotSession {
  explicit Teleoperation(const std::string& link = "delay=0", const RemoteSeat& seat = {},
                         const RemoteTrust& trust = {.per_contact = 0.0, .power = 0.0},
                         const PointRobotOptions& of_robot = {})
      : PointAtWall{PointRobot(wall_scene(), Vec3(0.0, 0.0, 0.02), of_robot)},
        RobotSession(robot, link, seat, trust) {}
};

}  // namespace feltwire::test
