#pragma once
// The report of feltwire-follower: JSON.

#include <string>

#include "client/followers/follower_loop.hpp"

namespace feltwire {

/// The report's text (docs/teleoperation.md has its keys).
std::string report_json(const FollowerSpec& robot, const FollowerRun& run,
                        const FollowerResult& result);
/// The report in a single line for people.
std::string report_line(const FollowerResult& result);

}  // namespace feltwire
