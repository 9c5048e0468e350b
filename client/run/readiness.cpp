#include "client/run/readiness.hpp"

#include <poll.h>

#include <cstdio>
#include <string>

#include "core/base/visible_text.hpp"

namespace feltwire {

bool get_ready(Device& device, const Signals& signals) {
  constexpr int kBetween = 10;  // [ms]
  pollfd waiting{signals.descriptor(), POLLIN, 0};
  std::string said;
  while (true) {
    const std::string wanted(device.prepare());
    if (wanted.empty()) return true;
    if (wanted != said)
      std::fprintf(stderr, "feltwire-client: no force yet: %s\n", visible(wanted).c_str());
    said = wanted;
    ::poll(&waiting, 1, kBetween);
    if (signals.take().end) return false;
  }
}

}  // namespace feltwire
