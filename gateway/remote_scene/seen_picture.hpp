#pragma once
// What an observer was shown, as a picture for viewers. No socket, no clock.

#include <vector>

#include "client/run/observed_scene.hpp"
#include "core/scene/scene.hpp"
#include "server/picture/picture.hpp"

namespace feltwire {

/// Fills `picture` with the hands and bodies. Of a hand without figures only its tool's place and
/// the force that its device holds are known: its proxy is its tool, and the scene asks for
/// nothing. Objects that do not move in `scene`, or are not in it, are left out: the server may
/// have another file.
void draw(const ObservedScene& seen, const Scene& scene, Picture& picture);

/// A description of each hand, as far as an observer knows it: number and tool.
std::vector<HandDescription> hands_of(const ObservedScene& seen, const Scene& scene);

}  // namespace feltwire
