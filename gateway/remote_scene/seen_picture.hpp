#pragma once
// An observer's data as a picture for viewers. It has no socket and no clock.

#include <vector>

#include "client/run/observed_scene.hpp"
#include "core/scene/scene.hpp"
#include "server/picture/picture.hpp"

namespace feltwire {

/// Fills `picture` with the hands and bodies. Of a hand without figures only its tool's place and
/// the force that its device holds are known: its proxy is its tool, and the scene commands no
/// force. Objects that do not move in `scene`, or are not in it, are left out, because the server
/// may have another file.
void draw(const ObservedScene& seen, const Scene& scene, Picture& picture);

/// A description of each hand, as far as an observer knows it: number and tool.
std::vector<HandDescription> hands_of(const ObservedScene& seen, const Scene& scene);

}  // namespace feltwire
