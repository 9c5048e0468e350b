#include "client/run/wait_until_ready.hpp"

#include <poll.h>

#include <cstdio>
#include <string>

#include "client/device/await_prepared.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {

bool wait_until_ready(Device& device, const Signals& signals) {
  constexpr int kBetween = 10;  // [ms] time between two checks of the device
  pollfd waiting{signals.descriptor(), POLLIN, 0};
  const auto tell = [](const std::string& wanted) {
    std::fprintf(stderr, "feltwire-client: no force yet: %s\n", visible(wanted).c_str());
  };
  return await_prepared(device, tell, [&](const std::string&) {
    ::poll(&waiting, 1, kBetween);
    return !signals.take().end;
  });
}

}  // namespace feltwire
