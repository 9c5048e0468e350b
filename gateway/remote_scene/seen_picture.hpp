#pragma once
// An observer's data as a picture for viewers. It has no socket and no clock.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/run/observed_scene.hpp"
#include "core/scene/scene.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/picture.hpp"

namespace feltwire {

/// Fills `picture` with the hands and bodies. Of a hand without figures only its tool's place and
/// the force that its device holds are known: its proxy is its tool, and the scene commands no
/// force. Objects that do not move in `scene`, or are not in it, are left out, because the server
/// may have another file. `told`: what the server says of its sessions, by rising number.
void draw(const ObservedScene& seen, const Scene& scene,
          std::span<const control::SessionDescription> told, Picture& picture);

/// The server's description of a hand, null if there is none. Precondition: `told` is sorted by
/// number.
const control::SessionDescription* told_of(std::span<const control::SessionDescription> told,
                                           std::uint32_t number);

/// A description of each hand: its tool, and what the server tells of its session. `now`: the time
/// at which it was told, of the pictures' clock.
std::vector<HandDescription> hands_of(const ObservedScene& seen, const Scene& scene,
                                      std::span<const control::SessionDescription> told,
                                      Nanoseconds now);

/// The scene with the materials that the server has in force, those of its objects from the first
/// on. Empty: `scene` has them already, or they do not fit it because the server has another file.
std::optional<Scene> with_materials(const Scene& scene, std::span<const Material> materials);

}  // namespace feltwire
