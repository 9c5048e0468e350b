#pragma once
// The result of a replay, for people and for programs.

#include <string>

#include "server/recording/scene_replay.hpp"

namespace feltwire {

/// "bit-equal", or the place of the first difference.
std::string verdict(const Replay& replay);
/// Whole lines. `took` [s]: the time of the replay.
std::string replay_text(const Replay& replay, double took);
/// A JSON object; docs/recording.md explains its fields.
std::string replay_json(const Replay& replay, double took);

}  // namespace feltwire
