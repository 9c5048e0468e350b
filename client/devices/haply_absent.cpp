// Replaces haply.cpp in a build without the WebSocket library.

#include <stdexcept>

#include "client/devices/haply.hpp"

namespace feltwire {

namespace {

[[noreturn]] void refuse_absent() {
  throw std::runtime_error(
      "haply: this feltwire-client was built without libwslay-dev, which speaks to the maker's "
      "service; install that package and build it again");
}

}  // namespace

OpenedDevice open_haply(const DeviceRequest&) { refuse_absent(); }
std::string haply_service(std::uint16_t) { refuse_absent(); }
std::string haply_usual_service() { refuse_absent(); }

}  // namespace feltwire
