#include "core/teleoperation/lead_engagement.hpp"

#include <array>

#include "core/base/enum_names.hpp"

namespace feltwire {

std::string_view name(LinkState state) {
  static constexpr std::array<const char*, static_cast<std::size_t>(kLastLinkState) + 1> kNames = {
      "disabled", "ready", "engaged", "clutched", "hold", "fault", "aligning"};
  return enum_name(kNames, state);
}

}  // namespace feltwire
