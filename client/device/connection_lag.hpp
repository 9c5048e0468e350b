#pragma once
// The lag that is assumed of a device's motors until somebody measures it, by its connection.

#include <string_view>

#include "core/device/device_file.hpp"

namespace feltwire {

/// How a device is connected to this machine.
struct Connection {
  std::string_view name;  // as a source names it: "USB"
  double lag;  // [s] an upper bound, by assumption, of the time from write() to the motor's force
};

/// Memory or ports that the processor writes to itself: what is left is the amplifier.
inline constexpr Connection kMappedConnection = {"PCI or a parallel port", 0.3e-3};
/// A force is a message, which waits for its turn on the bus.
inline constexpr Connection kUsbConnection = {"USB", 0.5e-3};
/// USB where the bus has a turn every millisecond only.
inline constexpr Connection kFullSpeedUsbConnection = {"USB at full speed", 1.5e-3};
/// As for USB.
inline constexpr Connection kUnknownConnection = {"a connection that the driver does not know",
                                                  0.5e-3};

/// Gives the specification of a real device the lag of its connection, with a source that begins
/// with "assumption" and names the connection. A specification that tells an actuation_lag, also
/// one of 0, or late_ticks above 0 stays as it is. No late ticks at all say nothing of the lag: a
/// force may still come within the tick.
void assume_lag(SourcedSpec& described, const Connection& connection);

}  // namespace feltwire
