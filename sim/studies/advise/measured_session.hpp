#pragma once
// A whole session of a case in virtual time, and what the hand and the machines got of it.

#include "sim/studies/advise/advice_setting.hpp"
#include "sim/studies/advise/drawn_cases.hpp"

namespace feltwire::advise {

struct Measured {
  double felt = 0.0;                      // [N/m] force over depth at the handle, at rest
  double oscillation = 0.0;               // [m] RMS of the handle (highpass_rms), second half
  double news_age = 0.0;                  // [s] mean age of the newest answered sample
  double up_kbit = 0.0, down_kbit = 0.0;  // [kbit/s]
  double server = 0.0, client = 0.0;      // [s] of computing for a second, without system calls
  // No more energy at the port than the device burned, with the dry friction that is known.
  bool passive = true;
  bool calm() const { return oscillation < 10e-6; }
};

/// A first press on a place. Computing times are measured if `timed`; all else is deterministic.
Measured measured_press(const DrawnCase& drawn, const Setting& setting, const Place& place,
                        bool timed);

}  // namespace feltwire::advise
