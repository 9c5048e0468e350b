#pragma once
// What a viewer of the live page says.

#include <optional>
#include <string>
#include <string_view>

#include "core/base/types.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/material_change.hpp"

namespace feltwire::web {

/// A change that an admin asks for: the material of an object, gravity, or the bound or the link of
/// a session, by which of the members is given.
struct ViewerSet {
  MaterialChange material;
  std::optional<Vec3> gravity;                           // [m/s^2]
  std::string session;                                   // its id, in decimal digits
  std::optional<std::string> mode, projection, storage;  // of that session
  std::optional<LinkQuality> link;  // that its client emulates; what is not given is 0
};

/// One JSON object; what it leaves out is not there, what else it has is not read.
struct ViewerMessage {
  std::optional<std::string> token;   // the first message: who it is
  std::optional<std::string> watch;   // the name of the scene that it wants to see
  std::optional<std::string> ticket;  // the name of a scene that another program shall see
  std::optional<std::string> hand;    // take or release
  std::optional<Vec3> point;          // [m] where its hand shall be; not finite: no three numbers
  // Of admins, about the scene that is watched.
  std::optional<std::string> admin;  // a token of this role, where the viewer's own has another
  std::optional<ViewerSet> set;
  std::optional<std::string> evict;  // a session's id
  bool reload = false;
};

/// Nothing where the text is no JSON object, a member of `set` is of another kind than it must be
/// or of no known name, or it is nested deeper than a message of this kind is.
std::optional<ViewerMessage> parse_viewer_message(std::string_view text);

}  // namespace feltwire::web
