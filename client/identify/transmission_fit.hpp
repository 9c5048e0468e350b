#pragma once
// Fits the transmission between motor and handle from sweeps that shake a handle up to its first
// resonance.

#include <span>

#include "client/identify/sweep_record.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The least part of a device's mass on either side of its transmission, by assumption. It counts
/// where the encoder is at the handle: then the readings tell the resonance alone.
inline constexpr double kLeastMassShare = 0.1;

/// The transmission along one axis. `valid`: the readings tell it.
struct TransmissionFit {
  bool valid = false;
  EncoderSide side = EncoderSide::motor;  // that the readings fit
  double resonance = 0.0;                 // [Hz] the first of the free handle
  double stiffness = 0.0;                 // [N/m] estimate
  double stiffness_bound = 0.0;           // [N/m] it is not less: the 99.9 % bound of the fit
  double handle_mass = 0.0;  // [kg] behind it; 0: not told, the encoder is at the handle
};

/// How the answer to a shaking force changes with its frequency tells the spring, and on which side
/// of it the encoder is. A motor with a mass m_m that pulls a handle of m_h by a spring k and a
/// damper c has, at the motor and at the handle,
///
///   x_m / f = 1 / (m_m s^2 + b s + m_h s^2 Z / (m_h s^2 + Z)),  Z = k + c s
///   x_h / f = Z / (m_h s^2 + Z)  x_m / f
///
/// and the force a hold, a delay and a first-order lag. At the motor, least squares give both
/// masses and the spring. At the handle they give k (1/m_m + 1/m_h), so the bound is for the least
/// share of the mass on either side.
///
/// `runs`: the shaken sweeps along one axis, of all frequencies, from the lowest on. Masses and
/// stiffness refer to the commanded newton.
TransmissionFit transmission_fit(std::span<const SweepRecord> runs);

}  // namespace feltwire
