#pragma once
// The messages of a viewer of the live page.

#include <optional>
#include <string>
#include <string_view>

#include "core/base/types.hpp"
#include "protocol/session/bound_words.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/material_change.hpp"

namespace feltwire::web {

/// A change that an admin requests: the material of an object, gravity, or the bound or the link of
/// a session. The given members decide which.
struct ViewerSet {
  MaterialChange material;
  std::optional<Vec3> gravity;       // [m/s^2]
  std::string session;               // its id, in decimal digits
  BoundWords bound;                  // of that session
  std::optional<LinkQuality> link;   // of its client's emulated link; missing numbers are 0
  std::optional<double> lead_share;  // of its hand
};

/// A JSON object. Missing members are empty, unknown ones are ignored.
struct ViewerMessage {
  std::optional<std::string> token;   // the first message: identifies the viewer
  std::optional<std::string> watch;   // the name of the scene that it wants to watch
  std::optional<std::string> ticket;  // the name of a scene for another program
  std::optional<std::string> hand;    // take or release
  std::optional<std::string> mode;    // with take: the hand's bounding method
  std::optional<Vec3> point;          // [m] target of its hand; not finite: no three numbers
  // For admins, about the watched scene.
  std::optional<std::string> admin;  // a token of this role, if the viewer's own has another
  std::optional<ViewerSet> set;
  std::optional<std::string> evict;  // a session's id
  bool reload = false;
  bool record = false;                   // the flight record of the scene
  std::optional<std::string> recording;  // start or stop, at the server
  std::optional<std::string> download;   // the name of a kept recording
};

/// Empty if the text is no JSON object, if a member of `set` is of a wrong type or unknown, or if
/// it is nested too deep.
std::optional<ViewerMessage> parse_viewer_message(std::string_view text);

}  // namespace feltwire::web
