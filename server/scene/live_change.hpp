#pragma once
// What may be changed while a scene runs, as plain values: the same change in the same state has
// the same result, bit for bit.

#include <cstdint>
#include <memory>
#include <string>
#include <variant>

#include "core/scene/scene.hpp"
#include "protocol/session/material_change.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// Another gravity on what moves.
struct GravityChange {
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
};
/// Other parameters of one session, of those that a running session can change (grant.hpp).
struct ParameterChange {
  std::uint64_t session = 0;
  SessionParameters parameters;
};
using LiveChange = std::variant<MaterialChange, GravityChange, ParameterChange>;

/// A change that was made.
struct Changed {
  std::string what;  // for the log: "object 'floor': stiffness 2000 -> 500 [N/m]"
  /// The scene from now on, which whoever made the change keeps; null: the same as before.
  std::shared_ptr<const Scene> scene;
};
/// A change, or why it was refused: the field, the range and the remedy. A refused change leaves
/// everything as it was.
using ChangeOutcome = std::variant<Changed, control::Refused>;

/// A copy of the scene with the change made. Throws std::invalid_argument that names the object,
/// the field and the remedy.
Changed changed(const Scene& scene, const MaterialChange& change);

/// The place of an object in the scene. Throws std::invalid_argument that names those there are.
std::size_t object_index(const Scene& scene, const std::string& name);

}  // namespace feltwire
