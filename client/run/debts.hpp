#pragma once
// The debts of the energy accounts of this process's devices, and how they are told.

#include <string>

#include "client/device/device.hpp"
#include "client/servo/overdraft.hpp"

namespace feltwire {

/// The reason that ended the force, for the last line of a run.
std::string text(const Overdraft& overdraft, const DeviceSpec& spec);

/// [J] with which the last run of this device in this process ended: another session, scene or law
/// forgives no debt. `device` is its name for the user. From then on there is memory for it.
double debt_of(const std::string& device);
/// A run of this device began with the debt `before` and ended with `after` [J]. Runs of devices
/// with the same name at the same time add up. Allocates nothing after debt_of().
void settle_debt(const std::string& device, double before, double after);

}  // namespace feltwire
