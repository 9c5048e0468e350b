#include "client/followers/follower_loop.hpp"

#include <poll.h>

#include <algorithm>
#include <optional>
#include <thread>

#include "client/followers/robot_datagrams.hpp"
#include "client/transport/backoff.hpp"
#include "client/transport/fleet_route.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/poll_until.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kJoinTime{3000};
/// The first and the longest limit of the waits between attempts to join again.
constexpr std::chrono::milliseconds kFirstWait{250}, kLongestWait{4000};
// [s] Time to brake the robot. It is enough for any real speed and acceleration.
constexpr double kBrakes = 0.25;
constexpr int kGoodbyes = 3;

/// Returns a join request. The protocol requires a device in it. A robot has no such device, so a
/// simulated device carries the robot's name.
control::JoinRequest request_of(const FollowerRun& run, const FollowerSpec& spec) {
  DeviceSpec device = builtin_device("simulated");
  device.name = spec.name;
  SessionParameters parameters;
  parameters.servo_period = spec.servo_period;
  control::JoinRequest request{run.name, run.scene, device, parameters, Role::follower};
  request.workspace = run.options.workspace;
  request.seat = run.seat;
  return request;
}

class FollowerLoop {
 public:
  FollowerLoop(Follower& robot, const FollowerRun& run, const std::atomic<bool>& stop)
      : robot_(robot),
        run_(run),
        stop_(stop),
        servo_(robot.spec(), run.options),
        route_(run.server),
        period_(from_seconds(robot.spec().servo_period)) {}

  FollowerResult run() {
    begun_ = usable_at_ = monotonic_now();
    join();
    while (true) {
      const bool over = serve();
      if (!over && run_.on_loss) run_.on_loss(result_.end);
      tick_on(kBrakes);
      if (over || !find_again()) break;
    }
    robot_.hold();
    result_.statistics = servo_.statistics();
    return result_;
  }

 private:
  void join() {
    const Joined joined = route_.join(request_of(run_, robot_.spec()), kJoinTime);
    silence_ = from_seconds(joined.accepted.silence_timeout);
    auto port = run_.open_port ? run_.open_port(joined.datagrams) : open_udp_port(joined.datagrams);
    datagrams_.emplace(joined.accepted.session, joined.keys);
    port_ = std::move(port);
    servo_.reconnected();
    servo_.sit(joined.accepted.workspace);
    ++result_.sessions;
    if (run_.on_join) run_.on_join();
  }

  /// Exchanges datagrams with the server until the session or the run ends. Returns true if the run
  /// ended.
  bool serve() {
    start();
    heard_ = monotonic_now();
    while (true) {
      const Nanoseconds now = wait();
      if (!take(now)) {
        result_.end = FollowerEnd::evicted;
        return false;
      }
      if (stop_.load() || ended(now)) {
        say_goodbye();
        result_.end = FollowerEnd::requested;
        return true;
      }
      if (now - heard_ > silence_) {
        result_.end = FollowerEnd::lost;
        return false;
      }
      if (now < next_) continue;
      port_->send(datagrams_->pack(tick(now)));
      pass(now);
    }
  }
  const RobotState& tick(Nanoseconds now) {
    const RobotState& said = servo_.tick(robot_, now);
    if (said.ok) usable_at_ = now;
    result_.duration = seconds(now - begun_);
    result_.faulty_for = seconds(now - usable_at_);
    if (run_.on_sample) run_.on_sample(said, servo_.target());
    return said;
  }
  bool ended(Nanoseconds now) const {
    return run_.duration > 0.0 && seconds(now - begun_) >= run_.duration;
  }

  /// Waits for a datagram, or until the next sample is due. Returns the present time.
  Nanoseconds wait() {
    Nanoseconds wake = next_;
    if (const auto due = port_->next_due()) wake = std::min(wake, *due);
    poll_until(port_->descriptor(), POLLIN, wake);
    const Nanoseconds now = monotonic_now();
    if (port_->delays()) port_->pass(now);
    return now;
  }

  /// Handles the received datagrams. Returns false if the server ended the session.
  bool take(Nanoseconds now) {
    for (int i = 0; i < DatagramPort::kBurst; ++i) {
      const std::optional<Bytes> datagram = port_->receive();
      if (!datagram) return true;
      RobotTarget target;
      GoodbyeReason reason{};
      switch (datagrams_->take(*datagram, target, reason)) {
        case RobotDatagrams::Arrival::target:
          heard_ = now;
          servo_.take(target, now);
          break;
        case RobotDatagrams::Arrival::goodbye:
          return false;
        case RobotDatagrams::Arrival::dropped:
          break;
      }
    }
    return true;
  }

  void start() { next_ = monotonic_now(); }
  void pass(Nanoseconds now) {
    const auto passed = (now - next_) / period_ + 1;
    result_.overruns += passed > 1 ? 1 : 0;
    next_ += passed * period_;
  }

  /// Runs the robot's servo for `time` [s] without a server. The robot brakes and then holds its
  /// position.
  void tick_on(double time) {
    servo_.reconnected();
    start();
    for (const Nanoseconds end = next_ + from_seconds(time); next_ < end;) {
      std::this_thread::sleep_for(next_ - monotonic_now());
      const Nanoseconds now = monotonic_now();
      tick(now);
      pass(now);
    }
  }

  bool find_again() {
    Nanoseconds now = monotonic_now();
    const Nanoseconds until = now + from_seconds(run_.patience);
    Backoff backoff(kFirstWait, kLongestWait, random_seed());
    for (; !stop_.load() && !ended(now) && now < until; now = monotonic_now()) {
      try {
        join();
        return true;
      } catch (const LastingError& error) {
        result_.refusal = error.what();
        return false;
      } catch (const SessionError&) {
        tick_on(seconds(backoff.next()));
      }
    }
    return false;
  }

  void say_goodbye() {
    for (int i = 0; i < kGoodbyes; ++i) port_->send_now(datagrams_->goodbye());
  }

  Follower& robot_;
  const FollowerRun& run_;
  const std::atomic<bool>& stop_;
  FollowerServo servo_;
  FleetRoute route_;
  Nanoseconds period_, silence_{0}, begun_{0}, next_{0}, heard_{0}, usable_at_{0};
  std::optional<RobotDatagrams> datagrams_;
  std::unique_ptr<DatagramPort> port_;
  FollowerResult result_;
};

}  // namespace

FollowerResult run_follower(Follower& robot, const FollowerRun& run,
                            const std::atomic<bool>& stop) {
  return FollowerLoop(robot, run, stop).run();
}

}  // namespace feltwire
