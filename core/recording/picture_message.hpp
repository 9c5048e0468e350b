#pragma once
// A foxglove.SceneUpdate of a recording (sample_messages.hpp), back to hands and bodies.

#include <optional>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// A hand or a moving body. World frame.
struct PictureEntity {
  std::string_view id;  // "hand 1", "body 2": part of the message
  bool is_hand = false;
  Pose pose;
  Vec3 force = Vec3::Zero();  // [N] on a hand
};

/// The entities; deletions are left out. Empty if the bytes are no such message. An entity of
/// another kind is left out.
std::optional<std::vector<PictureEntity>> read_picture(std::string_view bytes);

}  // namespace feltwire
