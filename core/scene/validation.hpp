#pragma once
// The rules for the values of a scene. Scenes from files and scenes from code obey the same rules.

#include <initializer_list>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "core/scene/scene.hpp"

namespace feltwire {

/// A value that breaks a rule: the field with its name in the scene file, the error, and the
/// remedy.
struct Violation {
  std::string field;
  std::string message;
};

using MaybeViolation = std::optional<Violation>;

/// Throws std::invalid_argument "whose: field: message". `whose`: "object 'ball'".
[[noreturn]] inline void refuse(const std::string& whose, const Violation& violation) {
  throw std::invalid_argument(whose + ": " + violation.field + ": " + violation.message);
}

inline constexpr double kMaxLength = 1e6;     // [m] sizes and coordinates
inline constexpr double kMaxStiffness = 1e9;  // [N/m]
inline constexpr double kMaxWallDepth = 0.1;  // [m] of a workspace's walls
inline constexpr double kMaxDamping = 1e6;    // [N s/m], viscous friction too
inline constexpr double kMaxFrictionCoefficient = 100.0;
inline constexpr double kLargestTravel = 1e3;       // [m], [rad] of a joint
inline constexpr std::size_t kMaxNameLength = 100;  // [bytes]

/// Each check returns the first rule that is broken, if any. Fields are relative to the argument
/// ("radius", "position.x").
std::optional<Violation> check(const Shape& shape);
std::optional<Violation> check(const Material& material);
/// An orientation need not be unit, but it must have a direction.
std::optional<Violation> check(const Pose& pose);
/// The normal need not be unit, but it must have a direction.
std::optional<Violation> check(const Start& start);
std::optional<Violation> check(const KeepOutBody& body);
std::optional<Violation> check(const Alignment& aligned);
std::optional<Violation> check(const RemoteSeat& seat);
std::optional<Violation> check(const ArmControl& arm);
/// Checks the name of a scene, an object, a material, a guide or a tool.
std::optional<Violation> broken_name(const std::string& name);

/// Checks a tool in a scene with these objects.
std::optional<Violation> check(const HandTool& tool, std::span<const Object> objects);
/// A tool as refuse() names it: "tool 'ball'", or "tool" for one without a name.
std::string description_of(const HandTool& tool);
/// Checks the number of tools to choose from.
std::optional<Violation> broken_tools(std::size_t count);
inline constexpr std::size_t kMaxTools = 64;

/// Checks a guide.
std::optional<Violation> check(const Guide& guide);

/// 0 < value <= most. `unit` with a blank and brackets: " [m]".
MaybeViolation positive(const char* field, double value, double most, const char* unit);
/// 0 <= value <= most.
MaybeViolation not_negative(const char* field, double value, double most, const char* unit);
/// The first violation of these, if there is one.
MaybeViolation first(std::initializer_list<MaybeViolation> found);

/// Scales an orientation to unit length. Precondition: check() found nothing.
void make_unit(Quaternion& orientation);

/// A number as text: the shortest one that reads back as the same double.
std::string number_text(double value);

}  // namespace feltwire
