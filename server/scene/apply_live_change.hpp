#pragma once
// Makes live changes of a scene or a session (protocol/session/live_change.hpp).

#include <memory>
#include <string>
#include <variant>

#include "core/scene/scene.hpp"
#include "protocol/session/live_change.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// A change that was made.
struct Changed {
  std::string what;  // for the log: "object 'floor': stiffness 2000 -> 500 [N/m]"
  /// The scene from now on, which the caller keeps; null: the same as before.
  std::shared_ptr<const Scene> scene;
};
/// A change, or why it was refused: the field, the range and the remedy. A refused change leaves
/// everything as it was.
using ChangeOutcome = std::variant<Changed, control::Refused>;

/// A copy of the scene with the change made. Throws std::invalid_argument that names the object,
/// the field and the remedy.
Changed changed(const Scene& scene, const MaterialChange& change);

/// Returns the index of an object in the scene. Throws std::invalid_argument that lists the
/// existing ones.
std::size_t object_index(const Scene& scene, const std::string& name);

}  // namespace feltwire
