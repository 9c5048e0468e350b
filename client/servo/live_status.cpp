#include "client/servo/live_status.hpp"

namespace feltwire {
namespace {

std::optional<double> balance_of(const Servo& servo) noexcept {
  return servo.account() ? std::optional(servo.account()->balance()) : std::nullopt;
}

RobotStatus robot_of(const Servo& servo) noexcept {
  RobotStatus status{.name = servo.robot_name()};
  if (!servo.remote()) return status;
  const auto& robot = servo.remote()->remote();
  status.state = robot.state;
  if (robot.turn) status.turn = robot.turn->norm();
  return status;
}

}  // namespace

LiveStatus live_status(const Servo& servo, double time, bool connected) noexcept {
  const ServoStatistics& s = servo.statistics();
  const ClockEstimate& clock = servo.server_clock();
  return {.time = time,
          .samples = s.samples,
          .network = {.lost = servo.lost_so_far(),
                      .round_trip_p50 = s.replies.round_trip.quantile(0.5),
                      .round_trip_p99 = s.replies.round_trip.quantile(0.99),
                      .clock_known = clock.known(),
                      .delay_up = clock.delay_up(),
                      .delay_down = clock.delay_down(),
                      .jitter_up = clock.jitter_up(),
                      .jitter_down = clock.jitter_down()},
          .force = length(servo.held().force()),
          .no_force = servo.no_force(),
          .oscillation = servo.measures().squares(),
          .displayed_stiffness = servo.measures().displayed_stiffness(),
          .energy = servo.port().delivered().total(),
          .answered_lately =
              servo.has_reply() && servo.command_age() < 0.5 * servo.parameters().hold_time,
          .connected = connected,
          .scene = {.recovering = servo.newest_reply().recovering,
                    .withholds_change = servo.withholds_change(),
                    .reloads = servo.newest_reply().reloads,
                    .fetched = servo.fetched()},
          .shapes = servo.shapes(),
          .near = servo.near(),
          .hand_credit = servo.hand_credit(),
          .contact_cuts = s.local_model.contact_cut,
          .account = {.balance = balance_of(servo), .cuts = s.law.account_cut},
          .robot = robot_of(servo),
          .device = {.faults = s.device.faults, .jumps = s.device.jumps}};
}

TickRecord tick_record(const Servo& servo, double time, Nanoseconds now) noexcept {
  return {.time = time,
          .position = servo.sample().pose.position,
          .elastic = servo.command().elastic,
          .frictional = servo.command().frictional,
          .held = servo.held().force(),
          .age = servo.has_reply() ? servo.command_age() : -1.0,
          .clock = now.count(),
          .orientation = servo.sample().pose.orientation,
          .torque = servo.held().torque,
          .balance = balance_of(servo),
          .account_cut = servo.account_cut(),
          .no_force = servo.no_force(),
          .robot = servo.remote() ? servo.remote()->remote().state : LinkState::disabled};
}

}  // namespace feltwire
