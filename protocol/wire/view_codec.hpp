#pragma once
// Internal to the codec: the view in a reply to an observer (protocol/wire/scene_view.hpp), to
// bytes and back.

#include "protocol/wire/datagram.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {

/// Writes the view. It does not allocate if the builder has room.
flatbuffers::Offset<wire::SceneView> build(flatbuffers::FlatBufferBuilder& builder,
                                           const SceneView& view);

/// Reads the view, with the checks of PROTOCOL.md in their order: count, order, not_finite. `out`
/// is unspecified unless the result is DropReason::none.
DropReason read(const wire::SceneView& from, SceneView& out) noexcept;
/// Returns the reason whose check comes first: the reasons have the order of the checks.
constexpr DropReason first_of(DropReason a, DropReason b) noexcept {
  if (a == DropReason::none || b == DropReason::none) return a == DropReason::none ? b : a;
  return a < b ? a : b;
}

}  // namespace feltwire
