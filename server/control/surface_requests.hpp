#pragma once
// The answers to clients that fetch surfaces or solids in full: lists and parts of a scene. They
// are computed on the control thread from a scene that nobody changes.

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/wire/control.hpp"
#include "server/picture/scene_in_view.hpp"

namespace feltwire {

/// The session that asks for a list or a part; empty: the request is for neither.
std::optional<std::uint64_t> session_of_fetch(const control::Message& request);

/// The list or the part, for a session with this tool (empty: the first), or the refusal.
/// Precondition: session_of_fetch(request) is not empty.
control::Message fetched(const control::Message& request, const SceneInView::CurrentScene& current,
                         const std::string& tool);

}  // namespace feltwire
