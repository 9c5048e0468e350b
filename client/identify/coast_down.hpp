#pragma once
// A second measurement of damping: a handle that is pushed and then left alone slows down.

#include <span>
#include <vector>

#include "client/identify/sweep_record.hpp"

namespace feltwire {

/// A push along an axis, and then no force along it.
struct CoastDown {
  Vec3 along = Vec3::UnitX();  // unit, of either sense
  double speed = 0.0;          // [m/s] of the push
  double from = 0.0;           // [amplitudes] from the centre, where the force ends
};

struct CoastDownRecord {
  CoastDown coast;
  std::vector<SweepTick> ticks;  // from the place on where the force is to end
};

/// Each axis at three speeds up to `top_speed` [m/s], both ways and from three places: what a
/// cogging adds at one place it takes at another. The two ways follow each other.
std::vector<CoastDown> coast_down_plan(int dof, double top_speed);

/// The fit of a free handle that slows down: m dv/dt = -b v - f_c -+ g. Both ways together, gravity
/// falls out, and a line through the speeds gives b.
struct DecayFit {
  double damping = 0.0, damping_error = 0.0;  // [N s/m]
  int freedom = 0;
  bool valid = false;  // it went far enough without a force
};

/// `runs` of all axes, in the plan's order; those along `axis` count. `mass` [kg]; `delay` [s] of
/// the readings after the forces.
DecayFit decay_fit(std::span<const CoastDownRecord> runs, const Vec3& axis, double mass,
                   double delay);

}  // namespace feltwire
