#pragma once
// The debts of the energy accounts of this process's devices, and how they are told.

#include <string>

#include "client/devices/device.hpp"
#include "client/servo/overdraft.hpp"

namespace feltwire {

/// The reason that ended the force, for the last line of a run.
std::string text(const Overdraft& overdraft, const DeviceSpec& spec);

/// [J] with which the last run of this device in this process ended: another session, scene or law
/// forgives no debt. `device` is its name for the user.
double debt_of(const std::string& device);
void keep_debt(const std::string& device, double debt);

}  // namespace feltwire
