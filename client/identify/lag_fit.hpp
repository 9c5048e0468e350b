#pragma once
// The lag from a written force to the reading that shows it, from sweeps that are shaken.

#include <span>

#include "client/identify/sweep_record.hpp"

namespace feltwire {

struct LagFit {
  double lag = 0.0, error = 0.0;  // [s] over all lines, and its standard error
  int freedom = 0;                // equations less unknowns
  bool valid = false;             // it was shaken enough for an estimate
};

/// Precondition: every run is shaken (Sweep::shake), of one line or of several.
///
/// In each way of a sweep the handle moves at constant speed, so dry friction is constant, and a
/// small force of one frequency shakes it. For a test function p(t) that is zero with its first
/// three derivatives at both ends of the way,
///
///   integral of f(t - L) p dt = m integral of x p'' dt - b integral of x p' dt
///
/// holds for the true movement x whatever it is. So places, speeds and their errors at the ends
/// make nothing. With p a window times exp(-j w t), the left side over the first integral is m(w) -
/// j b/w. Its phase tells the lag L: b makes less of it the higher w is, and L more. The four
/// cycles of a run are shaken in phases a quarter apart, and they count turned back to one phase.
/// Gravity, cogging and what friction does at a place are the same in all, and fall out. So does a
/// spring that changes along the way, as cogging is one: what it makes of a shake turns twice as
/// far. What a transmission or another loss adds to b grows as w^4 below its resonance and is
/// fitted too; it is never negative. Where m(w) differs by 30 % from that at the lowest frequency a
/// resonance is near, and these frequencies are left out.
LagFit lag_fit(std::span<const SweepRecord> runs);

}  // namespace feltwire
