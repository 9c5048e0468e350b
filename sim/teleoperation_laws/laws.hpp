#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// All laws, by name; ours is the last.
std::vector<std::string_view> law_names();
/// Throws std::invalid_argument that lists the laws if there is none with this name.
std::unique_ptr<TeleoperationLaw> make_law(std::string_view name, const Plant& plant);

}  // namespace feltwire::teleop
