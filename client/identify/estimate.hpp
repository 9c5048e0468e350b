#pragma once
// What a device burns and weighs, from sweeps of it that nobody holds: values in, values out.

#include <span>
#include <string>
#include <vector>

#include "client/identify/swept.hpp"

namespace feltwire {

/// Estimates, and the lower bounds that the account may count on. The bounds are of the commanded
/// newton: an amplifier that gives more or less than it is told makes no difference to the energy.
struct DeviceEstimate {
  Vec3 damping = Vec3::Zero();        // [N s/m] along x, y, z
  Vec3 damping_bound = Vec3::Zero();  // diag of this <= the damping matrix, coupled axes included
  double friction = 0.0;              // [N] of the direction that has least
  double friction_bound = 0.0;        // in every direction
  Vec3 mass = Vec3::Zero();           // [kg] along x, y, z
  double mass_bound = 0.0;            // in every direction
  double quantum = 0.0;             // [m] least step of a reading; of one that never repeats: tiny
  double noise = 0.0;               // [m] RMS of a handle at rest, the worst axis
  double delay = 0.0;               // [s] from a force to its reading, without the hold
  std::vector<std::string> doubts;  // why the estimates are not to be used; empty: nothing is odd
};

/// `rest`: ticks of a handle at rest. `dof`: 2 or 3.
///
/// Damping and friction are measured by the energy that a closed cycle takes. The work W of the
/// commanded force over a cycle of length L is what the device burned: gravity, cogging and springs
/// give back what they took, and the kinetic energy is the same again. So W / L = f_c + b p, with
/// p = (sum of v^2 dt) / L the mean speed along the way, and a line through the cycles of several
/// speeds gives both. Friction that is higher at low speed (stiction) makes the line less steep,
/// never steeper. A delay takes away from the work where the handle turns, so it is estimated
/// and made good in part, never in full. A bound is the 99.9 % lower bound of the fit, and of that
/// 80 %. Coupled axes: Gershgorin's circles, with the diagonals' sweeps.
///
/// Cross-check: the impulse of the same ticks, force = m a + b v + f_c sign v + g by least squares,
/// which also gives mass and delay. Where the two disagree about the damping, that is a doubt.
///
/// Precondition: the runs are those of sweep_plan(), in its order.
DeviceEstimate estimate(std::span<const SweptRun> runs, std::span<const SweptTick> rest, int dof);

}  // namespace feltwire
