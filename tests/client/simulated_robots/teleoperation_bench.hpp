#pragma once
// A hand, a server and a robot with an emulated link on either side of the server, on the test's
// clock. The servos of hand and robot make sealed datagrams; the server's sessions answer them.

#include <netinet/in.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/emulated_link/link.hpp"
#include "client/followers/robot_datagrams.hpp"
#include "client/hands/hand_device.hpp"
#include "client/servo/servo.hpp"
#include "client/simulated_robots/point_robot.hpp"
#include "client/transport/datagram_session.hpp"
#include "core/teleoperation/follower_servo.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"

namespace feltwire::test {

/// A hand that means to be at a given place, and its switch.
class ToldHand final : public HandDevice {
 public:
  ToldHand() : HandDevice(builtin_device("simulated"), {}) {}
  Vec3 meant = Vec3::Zero();                 // [m]
  bool pressed = false;                      // the switch
  std::uint32_t buttons = 0;                 // a bit each
  std::optional<double> gripper;             // [m] of its lever
  Quaternion turn = Quaternion::Identity();  // of its handle
  DeviceReading read(Nanoseconds now) noexcept override {
    DeviceReading reading = HandDevice::read(now);
    reading.pose.orientation = turn;
    reading.deadman = pressed;
    reading.buttons = buttons;
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

/// The server's scene: its only object is far away, and it has seats for robots.
inline Scene empty_scene(std::vector<RemoteSeat> seats) {
  Object far_away;
  far_away.name = "far";
  far_away.shape = Sphere{0.1};
  far_away.pose.position = Vec3(0.0, 0.0, -50.0);
  far_away.material = {.stiffness = 1000.0};
  Scene scene("empty", {far_away});
  scene.set_seats(std::move(seats));
  return scene;
}
inline Scene empty_scene(const RemoteSeat& seat = {}) { return empty_scene(std::vector{seat}); }

inline std::vector<std::string> names_of(const std::vector<RemoteSeat>& seats) {
  std::vector<std::string> names;
  for (const RemoteSeat& seat : seats) names.push_back(seat.name);
  return names;
}

/// The robot's environment: a wall at z = 0.
inline std::shared_ptr<const Scene> wall_scene(double stiffness = 2000.0) {
  Object wall;
  wall.name = "wall";
  wall.shape = Plane{};
  wall.material = {.stiffness = stiffness, .damping = 2.0};
  return std::make_shared<const Scene>("wall", std::vector<Object>{wall});
}

/// A hand, its servo, and its link to the server. Its first button selects the next robot.
struct HandSession {
  HandSession(std::uint64_t id, const std::string& link, std::uint64_t stream,
              const RemoteTrust& trust, std::vector<std::string> seats = {})
      : parameters(usual_parameters()),
        options([&] {
          ServoOptions o = protect_hand(parameters);
          o.leads = trust;
          o.seats = std::move(seats);
          o.seat_button = 1;
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
  double force() const { return servo.held().force().z(); }  // [N] pushes the hand up
  /// [J] the energy that the hand got beyond what the device burned.
  double made() const { return -servo.port().least_margin(); }

  SessionParameters parameters;
  ServoOptions options;
  ToldHand hand;
  Servo servo;
  DatagramSession hand_datagrams;
  TwoWayLink hand_link;
  bool hand_cut = false;
  std::function<void(Reply&)> change_reply;  // replaces the server's reply
  double fastest_fall = 0.0;                 // [N] largest fall of the hand's force in one tick
  Peer hand_peer{.address = {}, .length = sizeof(sockaddr_in)};
  Reply reply;

 private:
  double force_before_ = 0.0;
};

/// Any robot, its servo, and its link to the server. Its clock may drift.
struct FollowerSession {
  FollowerSession(Follower& any_robot, std::uint64_t id, const std::string& link,
                  std::uint64_t stream, Nanoseconds now)
      : driven(any_robot),
        follower(driven.spec()),
        robot_datagrams(id, keys(id)),
        robot_link(parse_link(link), stream, 4096),
        commanded(driven.read(now).commanded),
        begun_(now),
        robot_due_(now + from_seconds(driven.spec().servo_period)) {}

  void tell_states(SceneSessions& sessions, Nanoseconds now, DatagramBuffer& room) {
    while (const auto d = robot_link.up.leave(now))
      if (!robot_cut) sessions.receive(*d, robot_peer, now, room);
  }
  void send_target(SceneSessions& sessions, std::size_t seat, Nanoseconds now,
                   DatagramBuffer& room) {
    Peer to;
    if (const Bytes due = sessions.forward(seat, now, to, room); !due.empty()) {
      EXPECT_EQ(to.length, robot_peer.length);
      robot_link.down.enter(due, now);
    }
  }
  void hear_targets(Nanoseconds now) {
    while (const auto d = robot_link.down.leave(now))
      if (!robot_cut && robot_datagrams.take(*d, target, reason) == RobotDatagrams::Arrival::target)
        follower.take(target, robot_time(now));
  }
  void sample_robot(Nanoseconds now) {
    for (; robot_due_ <= robot_time(now); robot_due_ += from_seconds(driven.spec().servo_period)) {
      RobotState said = follower.tick(driven, robot_due_);
      if (lie) lie(said);
      robot_link.up.enter(robot_datagrams.pack(said), now);
      farthest_step =
          std::max(farthest_step, (said.commanded.position - commanded.position).norm());
      commanded = said.commanded;
    }
  }
  /// The time on the robot's own clock.
  Nanoseconds robot_time(Nanoseconds now) const {
    return now + Nanoseconds(std::llround(drift * static_cast<double>((now - begun_).count())));
  }

  Follower& driven;
  double drift = 0.0;  // [s/s] by which the robot's clock is fast
  FollowerServo follower;
  RobotDatagrams robot_datagrams;
  TwoWayLink robot_link;
  bool robot_cut = false;
  std::function<void(RobotState&)> lie;  // replaces the robot's state
  double farthest_step = 0.0;            // [m] largest step of the robot's held target in one tick
  Pose commanded;                        // the held target
  Peer robot_peer{.address = {}, .length = sizeof(sockaddr_in6)};
  RobotTarget target;
  GoodbyeReason reason = GoodbyeReason::leaving;

 private:
  Nanoseconds begun_;
  Nanoseconds robot_due_;  // its next sample, on its own clock
};

/// A hand, a server, and the robot on its scene's first seat.
struct RobotSession : HandSession, FollowerSession {
  static constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
  static constexpr Nanoseconds kStart = std::chrono::seconds(100);
  static constexpr std::uint64_t kHand = 0x700, kRobot = 0x800;

  explicit RobotSession(Follower& any_robot, const std::string& link = "delay=0",
                        Scene of_server = empty_scene(),
                        const RemoteTrust& trust = {.per_contact = 0.0, .power = 0.0})
      : HandSession(kHand, link, 0, trust, names_of(of_server.seats())),
        FollowerSession(any_robot, kRobot, link, 1, kStart),
        scene(std::move(of_server)),
        server(std::make_unique<SceneSessions>(scene, std::chrono::seconds(2), 8)) {
    hand.put(Vec3(0.1, -0.2, 0.3));
    join(kHand, Role::operator_);
    seat(*this, kRobot, scene.seats().front().name);
  }

  control::Message ask_to_join(std::uint64_t id, Role role, const std::string& name = {}) {
    control::JoinRequest request{"tester", "empty", hand.spec(), parameters, role};
    request.seat = name;
    return server->answer(request, id, keys(id), now);
  }
  void join(std::uint64_t id, Role role) {
    if (role == Role::follower) return seat(*this, id, {});
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(ask_to_join(id, role)));
  }
  void seat(FollowerSession& robot, std::uint64_t id, const std::string& name) {
    const control::Message answer = ask_to_join(id, Role::follower, name);
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
    robot.follower.sit(std::get<control::JoinAccepted>(answer).workspace);
  }

  void tick() {
    now += kPeriod;
    reach(*server, now, room);
    for (HandSession* other : others) other->reach(*server, now, room);
    each_robot([&](FollowerSession& robot) { robot.tell_states(*server, now, room); });
    for (std::size_t i = 0; i <= other_robots.size(); ++i)
      (i == 0 ? *this : *other_robots[i - 1]).send_target(*server, i, now, room);
    hear(now);
    for (HandSession* other : others) other->hear(now);
    each_robot([&](FollowerSession& robot) { robot.hear_targets(now); });
    sample(now);
    for (HandSession* other : others) other->sample(now);
    each_robot([&](FollowerSession& robot) { robot.sample_robot(now); });
  }
  void run(double time) {
    for (double t = 0.0; t < time; t += 1e-3) tick();
  }
  /// The hand means to move by `way`, smoothly, within the time.
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

  LinkState state(std::size_t seat = 0) const { return server->link_state(seat); }

  Scene scene;
  std::unique_ptr<SceneSessions> server;
  std::vector<HandSession*> others;            // more hands in the scene
  std::vector<FollowerSession*> other_robots;  // on the other seats
  Nanoseconds now = kStart;
  DatagramBuffer room;

 private:
  template <class Work>
  void each_robot(const Work& work) {
    work(*this);
    for (FollowerSession* robot : other_robots) work(*robot);
  }
};

struct PointAtWall {
  PointRobot robot;
};

/// A session with a point robot 20 mm in front of a wall.
struct Teleoperation : PointAtWall, RobotSession {
  explicit Teleoperation(const std::string& link = "delay=0", const RemoteSeat& seat = {},
                         const RemoteTrust& trust = {.per_contact = 0.0, .power = 0.0},
                         const PointRobotOptions& of_robot = {})
      : PointAtWall{PointRobot(wall_scene(), Vec3(0.0, 0.0, 0.02), of_robot)},
        RobotSession(robot, link, empty_scene(seat), trust) {}
};

}  // namespace feltwire::test
