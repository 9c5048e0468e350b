#pragma once
// Leads a handle that nobody holds along the sweeps of identify, and gives up on anything odd.
// Positions in, forces out: it knows neither a clock nor a device.

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "client/identify/estimate.hpp"
#include "client/identify/sweep_plan.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

struct IdentifyLimits {
  double amplitude = 0.0;  // [m] of a sweep, to either side of where the handle is at the start
  double travel = 0.0;     // [m] from there; beyond it, it gives up
  double top_speed = 0.0;  // [m/s] of the fastest sweep
  double speed = 0.0;      // [m/s] beyond it, it gives up
  double force = 0.0;      // [N] that is never exceeded
  double late = 0.05;      // [s] between two readings; beyond it, it gives up
};

/// A quarter of the workspace, 0.25 m/s, 15 % of the greatest force (or `force`, up to the
/// continuous one), and less where the turns would be too sharp. Throws std::invalid_argument for
/// a force that is not possible.
IdentifyLimits identify_limits(const DeviceSpec& spec, std::optional<double> force = {});

class Identification {
 public:
  enum class State : std::uint8_t { measuring, done, gave_up };

  /// `period` [s]: the shortest time between two readings, for which there is room.
  Identification(const DeviceSpec& spec, const IdentifyLimits& limits, double period);

  /// The force [N] to hold from this reading on; zero when it is over. `time` [s] rises.
  Vec3 step(double time, const Vec3& position) noexcept;
  /// Tells the force [N] that the device really holds.
  void held(const Vec3& force) noexcept;
  /// The device has a fault, or somebody asks to stop: the force is zero from now on.
  void give_up(const char* why) noexcept;

  State state() const { return state_; }
  std::string_view why() const { return why_; }  // it gave up; else empty
  double progress() const;                       // 0..1
  int line() const;  // that it sweeps along now, in the plan's order; -1: none
  double duration() const { return duration_; }      // [s] of it all
  double largest_force() const { return largest_; }  // [N] that was held

  /// Precondition: done.
  DeviceEstimate estimate() const { return feltwire::estimate(runs_, rest_, dof_); }

 private:
  enum class Phase : std::uint8_t { rest, approach, sweep, fade };

  bool odd(double time, const Vec3& position) noexcept;
  Vec3 pull(double time, const Vec3& position) noexcept;
  void record(double time, const Vec3& position) noexcept;
  void begin(Phase phase, double time) noexcept;
  void look_for_turn(double in_phase) noexcept;

  IdentifyLimits limits_;
  int dof_;
  std::vector<SweptRun> runs_;
  std::vector<SweptTick> rest_;
  std::vector<SweptTick>* recorded_ = nullptr;  // where held() completes the last tick
  double duration_ = 0.0;

  State state_ = State::measuring;
  const char* why_ = "";
  Phase phase_ = Phase::rest;
  std::size_t run_ = 0;
  bool started_ = false;
  double first_ = 0.0, phase_began_ = 0.0, last_ = 0.0;  // [s]
  Vec3 start_ = Vec3::Zero(), last_position_ = Vec3::Zero();
  Vec3 velocity_ = Vec3::Zero();                       // [m/s] filtered
  Vec3 led_ = Vec3::Zero(), led_from_ = Vec3::Zero();  // [m] of the start
  Vec3 force_ = Vec3::Zero();
  double largest_ = 0.0;
};

}  // namespace feltwire
