#pragma once
// Internal to protocol/wire: values of control messages, between the wire and the program.

#include <limits>
#include <string>

#include "core/base/types.hpp"
#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

inline wire::Vector wire_vector(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 vector(const wire::Vector& v) { return {v.x(), v.y(), v.z()}; }
inline wire::Turn wire_turn(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Quaternion turn(const wire::Turn& t) { return {t.w(), t.x(), t.y(), t.z()}; }

inline wire::FeltMaterial wire_material(const Material& m) {
  return {m.stiffness, m.damping, m.static_friction, m.dynamic_friction, m.viscous_friction};
}
inline Material material(const wire::FeltMaterial& m) {
  return {m.stiffness(), m.damping(), m.static_friction(), m.dynamic_friction(),
          m.viscous_friction()};
}

/// The enums of the values have the order of the wire.
template <class Wire, class Enum>
Wire wire_enum(Enum value) {
  return static_cast<Wire>(value);
}
/// False when there is no such enumerator.
template <class Enum, class Wire>
bool read_enum(Wire wire, Enum& out) {
  if (wire > Wire::MAX) return false;
  out = static_cast<Enum>(wire);
  return true;
}

inline flatbuffers::Offset<flatbuffers::String> name_if_any(flatbuffers::FlatBufferBuilder& builder,
                                                            const std::string& text) {
  return text.empty() ? 0 : builder.CreateString(text);
}
/// Reads an optional name. An absent name leaves `out` unchanged.
inline bool read_name(const flatbuffers::String* text, std::string& out,
                      std::size_t longest = kMaxName) {
  if (text == nullptr) return true;
  if (text->size() > longest) return false;
  out.assign(text->c_str(), text->size());
  return true;
}

}  // namespace feltwire::control
