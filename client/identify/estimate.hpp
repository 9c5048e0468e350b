#pragma once
// Estimates a device's damping, friction and mass from sweeps of a handle that nobody holds. Values
// in, values out.

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/identify/coast_down.hpp"
#include "client/identify/sweep_record.hpp"
#include "client/identify/transmission_fit.hpp"

namespace feltwire {

/// Estimates, and the lower bounds for the account. The bounds refer to the commanded newton: an
/// amplifier that gives more or less makes no difference to the energy.
struct DeviceEstimate {
  Vec3 damping = Vec3::Zero();        // [N s/m] along x, y, z
  Vec3 damping_bound = Vec3::Zero();  // diag of this <= the damping matrix, coupled axes included
  double friction = 0.0;              // [N] in the direction with the least
  double friction_bound = 0.0;        // in every direction
  Vec3 mass = Vec3::Zero();           // [kg] along x, y, z
  double mass_bound = 0.0;            // in every direction
  double quantum = 0.0;  // [m] smallest step of a reading; tiny if readings never repeat
  double noise = 0.0;    // [m] RMS of a handle at rest, the worst axis
  double tick = 0.0;     // [s] mean time between two readings
  double lag = 0.0;      // [s] from a force to the reading that shows it, without the hold
  std::optional<double> lag_bound{};              // [s] it is not longer; empty: it cannot be told
  std::optional<TransmissionFit> transmission{};  // of the softest axis; empty: it cannot be told
  // [N s/m] the damping by the decay, and what it is at most; empty and infinite where the handle
  // stopped too soon to tell.
  std::array<std::optional<double>, 3> decay{};
  Vec3 decay_limit = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::vector<std::string> doubts;  // why the estimates must not be used; empty: there is no doubt
};

/// `rest`: ticks of a handle at rest. `dof`: 2 or 3.
///
/// Damping and friction are measured by the energy that a closed cycle takes. The work W of the
/// commanded force over a cycle of length L is the energy that the device burned: gravity, cogging
/// and springs return the energy that they took, and the kinetic energy is the same again. So W / L
/// = f_c + b p, with p = (sum of v^2 dt) / L the mean speed along the path, and a line through the
/// cycles of several speeds gives both. Friction that is higher at low speed (stiction) makes the
/// line less steep, never steeper. A delay takes away from the work where the handle turns; it is
/// estimated and corrected in part, never in full. A bound is 80 % of the 99.9 % lower bound of the
/// fit. Coupled axes: Gershgorin's circles, with the diagonals' sweeps.
///
/// Cross-check: the impulse of the same ticks, force = m a + b v + f_c sign v + g by least squares,
/// which also gives mass and delay. And the decay of the coasts, without a force, times that mass.
/// A damping above what the decay can be is lowered to that. Where the energy says more than the
/// impulse or the decay by a third, that is a doubt.
///
/// The lag: lag_fit(). Its bound is the 99.9 % upper bound of the fit, and 40 us and 2 % more.
///
/// The transmission: transmission_fit() of each axis. Its bound is 80 % of that of the fit.
///
/// Precondition: the runs are those of sweep_plan(), then of shaken_plan() and of resonance_plan(),
/// and the coasts those of coast_down_plan(), in their order.
DeviceEstimate estimate(std::span<const SweepRecord> runs, std::span<const CoastDownRecord> coasts,
                        std::span<const SweepTick> rest, int dof);

}  // namespace feltwire
