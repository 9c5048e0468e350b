#pragma once
// What a viewer of the live page says.

#include <optional>
#include <string>
#include <string_view>

#include "core/base/types.hpp"

namespace feltwire::web {

/// One JSON object; what it leaves out is not there, what else it has is not read.
struct ViewerMessage {
  std::optional<std::string> token;   // the first message: who it is
  std::optional<std::string> watch;   // the name of the scene that it wants to see
  std::optional<std::string> ticket;  // the name of a scene that another program shall see
  std::optional<std::string> hand;    // take or release
  std::optional<Vec3> point;          // [m] where its hand shall be; not finite: no three numbers
};

/// Nothing where the text is no JSON object, or nested deeper than a message of this kind is.
std::optional<ViewerMessage> parse_viewer_message(std::string_view text);

}  // namespace feltwire::web
