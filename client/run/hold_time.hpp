#pragma once
// The hold time that a servo period needs.

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// Servo periods in the shortest hold time. A command that comes back in the next tick is a period
/// old, or two, and fades from half of the hold time on. A device that sets the pace has a fault
/// when its tick is late by a quarter of the hold time. So a shorter one would end every force, or
/// the session.
inline constexpr double kPeriodsInHoldTime = 5.0;

/// A hold time that is too short for the servo period is lengthened if it `follows`. Otherwise
/// throws std::invalid_argument that names the options that help. Does nothing for a period that
/// is not possible.
void choose_hold_time(SessionParameters& parameters, bool follows);

/// Throws std::invalid_argument that names the options that help if a client with these parameters
/// may say nothing for as long as the server waits, `silence_timeout` [s]: its session would end.
void require_heard(const SessionParameters& parameters, double silence_timeout);

}  // namespace feltwire
