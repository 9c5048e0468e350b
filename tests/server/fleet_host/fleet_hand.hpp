#pragma once
// A hand in a fleet, by the client library: it joins, feels the floor, and joins again.

#include <atomic>
#include <cmath>
#include <thread>

#include "client/device/device.hpp"
#include "client/servo/servo_loop.hpp"
#include "client/transport/fleet_route.hpp"
#include "client/transport/reconnector.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/net/poll_until.hpp"

namespace feltwire::test {

/// A hand that moves into the floor and out of it. Its rate has no simple ratio to that of the
/// statuses (4 Hz), so that they see all of its movement.
class DippingDevice final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override {
    constexpr double kDepth = 0.002, kRate = 3.3;  // [m], [1/s]
    if (begun_.count() == 0) begun_ = now;
    const double turns = kRate * 1e-9 * static_cast<double>((now - begun_).count());
    DeviceReading reading;
    reading.pose.position = {0.0, 0.0, kDepth * std::cos(2.0 * M_PI * turns)};
    return reading;
  }
  Command write(const Command& on_hand) noexcept override { return on_hand; }
  void release() noexcept override {}

 private:
  DeviceSpec spec_ = builtin_device("simulated");
  Nanoseconds begun_{0};
};

/// Sees every tick of a hand: the longest time without a session, and the largest step up of the
/// force that the hand's own movement does not explain.
class TickWatch final : public TickListener {
 public:
  void ticked(const TickRecord& tick, bool connected) noexcept override {
    constexpr double kStiffness = 500.0, kLate = 0.005;  // [N/m], [s] no step between such ticks
    if (connected) lost_at_ = tick.time;
    if (tick.time - lost_at_ > without_session_) without_session_ = tick.time - lost_at_;
    const double force = tick.held.norm(), elapsed = tick.time - before_.time;
    const double moved = (tick.position - before_.position).norm();
    const double step = force - before_.held.norm() - kStiffness * moved;
    if (elapsed < kLate && step > step_up_) step_up_ = step;
    before_ = tick;
  }
  double without_session() const { return without_session_; }  // [s]
  double step_up() const { return step_up_; }                  // [N]

 private:
  double lost_at_ = 0.0;
  TickRecord before_;
  std::atomic<double> without_session_{0.0}, step_up_{0.0};
};

class FleetHand {
 public:
  static constexpr std::chrono::milliseconds kPatience{10'000};

  FleetHand(const ServerAccess& server, const std::string& scene)
      : FleetHand(FleetRoute(server), {"tester", scene, DippingDevice().spec(), patient()}) {}
  ~FleetHand() {
    stop_.set();
    loop_.join();
    attendant_.join();
  }
  FleetHand(const FleetHand&) = delete;
  FleetHand& operator=(const FleetHand&) = delete;

  /// How often a force was seen on the hand while answers came.
  std::uint64_t felt() const { return felt_.load(); }
  std::uint64_t losses() const { return losses_.load(); }
  /// Sessions after the first one.
  std::uint64_t rejoins() const { return rejoins_.load(); }
  /// The control port of the host of its newest session.
  std::uint16_t port() const { return port_.load(); }
  const TickWatch& ticks() const { return ticks_; }
  const Epoch& first_epoch() const { return joined_.accepted.epoch; }

 private:
  static SessionParameters patient() {
    SessionParameters parameters;
    parameters.hold_time = 1.0;  // [s] longer than a busy machine delays a thread: no debt
    return parameters;
  }
  FleetHand(FleetRoute route, control::JoinRequest request)
      : route_(std::move(route)),
        joined_(route_.join(request, kPatience)),
        transport_({joined_.datagrams, joined_.accepted.session, joined_.keys},
                   joined_.accepted.parameters, false),
        servo_(device_.spec(), joined_.accepted.parameters),
        port_(joined_.host.endpoint.port) {
    request.parameters = joined_.accepted.parameters;
    reconnector_.emplace(route_, std::move(request), sessions_);
    const Nanoseconds silence = from_seconds(joined_.accepted.silence_timeout);
    loop_ = std::thread([this, silence] {
      run_servo_loop(device_, servo_, transport_,
                     {.silence_timeout = silence,
                      .patience = std::chrono::seconds(60),
                      .rejoined = &sessions_},
                     stop_, {.status = &statuses_, .listener = &ticks_}, result_);
    });
    attendant_ = std::thread([this] { attend(); });
  }

  void attend() {
    constexpr double kFelt = 0.05;  // [N]
    constexpr Nanoseconds kBetween = std::chrono::milliseconds(10);
    bool connected = true;
    while (!stop_.is_set()) {
      LiveStatus status;
      while (statuses_.pop(status)) {
        if (connected && !status.connected) ++losses_;
        connected = status.connected;
        if (status.connected && status.answered_lately && status.force > kFelt) ++felt_;
      }
      reconnector_->look(connected, Reconnector::Clock::now());
      rejoins_ = reconnector_->sessions();
      if (reconnector_->sessions() > 0) port_ = reconnector_->host().endpoint.port;
      poll_until(stop_.descriptor(), POLLIN, monotonic_now() + kBetween);
    }
  }

  DippingDevice device_;
  TickWatch ticks_;
  FleetRoute route_;
  Joined joined_;
  Transport transport_;
  Servo servo_;
  Ring<SessionAddress> sessions_{4};
  Ring<LiveStatus> statuses_{64};
  std::optional<Reconnector> reconnector_;
  Event stop_;
  LoopResult result_;
  std::atomic<std::uint64_t> felt_{0}, losses_{0}, rejoins_{0};
  std::atomic<std::uint16_t> port_;
  std::thread loop_, attendant_;
};

}  // namespace feltwire::test
