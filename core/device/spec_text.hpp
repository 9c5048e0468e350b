#pragma once
// What people are shown of a specification: its numbers and where they come from.

#include <string>
#include <vector>

#include "core/device/device_file.hpp"

namespace feltwire {

/// One line a number: field, value, unit, source. Numbers that the device has not (torque of one
/// without rotation) and that nobody told a source of are left out.
std::string spec_table(const SourcedSpec& described);

/// A sentence for each number that the account counts on and that is an assumption: "damping 0.05
/// N s/m is an assumption; measure yours with feltwire-client identify". Empty: there is none.
std::vector<std::string> assumptions(const SourcedSpec& described);

}  // namespace feltwire
