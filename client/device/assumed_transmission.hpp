#pragma once
// The transmission that is assumed of a real device until somebody measures it, by its drive.

#include <string_view>

#include "core/device/device_file.hpp"

namespace feltwire {

/// The part between a device's motors and its handle. The encoder is at the motor.
struct Drive {
  std::string_view name;  // as a source names it: "a cable drive"
  double stiffness;       // [N/m] a lower bound, by assumption
};

/// Cable drives are usually given with 3 to 20 kN/m.
inline constexpr Drive kCableDrive = {"a cable drive", 3e3};
/// The least of the stiffnesses in the data sheet of a Touch, as repeated by others: 1.02 kN/m. The
/// sheet does not say of what.
inline constexpr Drive kSmallCableDrive = {"a small cable drive", 1e3};
/// As for a cable drive.
inline constexpr Drive kUnknownDrive = {"a drive that is not known", 3e3};

/// Gives the specification of a real device the transmission of its drive, with a source that
/// begins with "assumption" and names the drive. A specification that tells a
/// transmission_stiffness, also one of 0, or an encoder at the handle stays as it is.
void assume_transmission(SourcedSpec& described, const Drive& drive);

}  // namespace feltwire
