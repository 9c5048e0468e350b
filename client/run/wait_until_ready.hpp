#pragma once
// Before a session: a person homes the device, or takes its stylus out of the inkwell.

#include "client/device/device.hpp"
#include "client/run/supervise_session.hpp"

namespace feltwire {

/// Waits until the device can give force (Device::prepare()), and prints what a person must do.
/// False: a signal ended the wait.
bool wait_until_ready(Device& device, const Signals& signals);

}  // namespace feltwire
