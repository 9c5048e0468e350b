#pragma once
// Leads a handle that nobody holds along the sweeps of identify, shakes it, pushes it and lets it
// coast, and stops on any fault. Its input is positions, its output forces: it has no clock and no
// device.

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "client/identify/estimate.hpp"
#include "client/identify/sweep_plan.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

struct IdentifyLimits {
  double amplitude = 0.0;  // [m] of a sweep, to either side of the handle's first place
  double travel = 0.0;     // [m] largest distance from there; beyond it, it stops
  double top_speed = 0.0;  // [m/s] of the fastest sweep
  double speed = 0.0;      // [m/s] beyond it, it stops
  double force = 0.0;      // [N] largest force
  double late = 0.05;      // [s] largest time between two readings; beyond it, it stops
};

/// A quarter of the workspace, 0.25 m/s, 15 % of the greatest force (or `force`, up to the
/// continuous one), and less if the turns would be too sharp. Throws std::invalid_argument for an
/// impossible force.
IdentifyLimits identify_limits(const DeviceSpec& spec, std::optional<double> force = {});

class Identification {
 public:
  enum class State : std::uint8_t { measuring, done, gave_up };

  /// `period` [s]: the shortest time between two readings; it sizes the memory.
  Identification(const DeviceSpec& spec, const IdentifyLimits& limits, double period);

  /// Returns the force [N] to hold from this reading on; zero when it is over. `time` [s] rises.
  Vec3 step(double time, const Vec3& position) noexcept;
  /// Takes the force [N] that the device really holds.
  void held(const Vec3& force) noexcept;
  /// The device has a fault, or the user stops it: the force is zero from now on.
  void give_up(const char* why) noexcept;

  State state() const { return state_; }
  std::string_view why() const { return why_; }  // the reason of a stop; else empty
  double progress() const;                       // 0..1
  int line() const;                              // the present sweep, in the plan's order; -1: none
  double duration() const { return duration_; }  // [s] of the whole measurement
  double largest_force() const { return largest_; }  // [N] held so far

  /// Precondition: done.
  DeviceEstimate estimate() const {
    return feltwire::estimate(recordings_.sweeps, recordings_.coasts, recordings_.rest, dof_);
  }

 private:
  enum class Phase : std::uint8_t { rest, approach, sweep, push, coast, brake, fade };

  bool odd(double time, const Vec3& position) noexcept;
  Vec3 pull(double time, const Vec3& position) noexcept;
  double shaken(const Sweep& sweep, double in_phase, double span) noexcept;
  void record(double time, const Vec3& position) noexcept;
  void begin(Phase phase, double time) noexcept;
  void look_for_turn(double in_phase) noexcept;
  void next(double time) noexcept;
  bool sweeps() const noexcept { return run_ < recordings_.sweeps.size(); }
  const Vec3& line_along() const noexcept;

  struct Recordings {
    std::vector<SweepRecord> sweeps;
    std::vector<CoastDownRecord> coasts;  // after all sweeps
    std::vector<SweepTick> rest;
    std::vector<SweepTick>* open = nullptr;  // where held() completes the last tick
  };
  struct Handle {
    bool known = false;                                  // there was a reading
    double time = 0.0;                                   // [s] of the newest reading
    Vec3 start = Vec3::Zero(), position = Vec3::Zero();  // [m] at the first and newest reading
    Vec3 velocity = Vec3::Zero();                        // [m/s] filtered
  };
  struct Shake {
    Vec3 force = Vec3::Zero();        // [N] the part of the force that shakes
    double level = 0.0, swing = 0.0;  // [N] its amplitude, [m/s] what it makes
  };

  IdentifyLimits limits_;
  int dof_;
  Recordings recordings_;
  double duration_ = 0.0;

  State state_ = State::measuring;
  const char* why_ = "";
  Phase phase_ = Phase::rest;
  std::size_t run_ = 0, coast_ = 0;
  double first_ = 0.0, phase_began_ = 0.0;  // [s]
  Handle handle_;
  Vec3 led_ = Vec3::Zero(), led_from_ = Vec3::Zero();  // [m] of the start
  double coasted_ = 0.0;                               // [m/s] at the end of a coast
  Vec3 force_ = Vec3::Zero();
  Shake shake_;
  double largest_ = 0.0;
};

}  // namespace feltwire
