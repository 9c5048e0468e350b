#include "server/scene/slow_down.hpp"

#include <algorithm>
#include <stdexcept>

namespace feltwire {

SlowDownOrder slow_down_order(std::string_view text) {
  SlowDownOrder order;
  if (text == "off") return order;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto* const name = std::ranges::find(kSlowedNames, text.substr(begin, end - begin));
    const auto kind = static_cast<Slowed>(name - kSlowedNames.begin());
    if (name == kSlowedNames.end() || std::ranges::find(order, kind) != order.end())
      throw std::invalid_argument(
          "must be observers, hands, both in the order in which they are slowed down "
          "(observers,hands), or off");
    order.push_back(kind);
    begin = end + 1;
  }
  return order;
}

}  // namespace feltwire
