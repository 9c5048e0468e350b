#include "client/app/open_client.hpp"

#include <utility>

#include "client/emulated_link/emulated_port.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kLinkRoom = 1 << 13;  // capacity in datagrams: 0.8 s at 10 kHz

}  // namespace

std::unique_ptr<Device> hand_device(OpenedDevice opened, ClientOptions& options) {
  options.hooks.true_energy = std::move(opened.true_energy);
  options.emergency = std::make_shared<EmergencyStop>();
  auto device = std::make_unique<ProtectedDevice>(std::move(opened.device), options.protection,
                                                  options.emergency);
  return std::make_unique<MappedDevice>(std::move(device), options.mapping);
}

std::function<std::unique_ptr<DatagramPort>(const Address&)> port_opener(
    const ClientOptions& options) {
  return [dscp = options.dscp,
          link = options.link](const Address& scene) -> std::unique_ptr<DatagramPort> {
    auto line = open_udp_port(scene, dscp);
    if (!link) return line;
    return std::make_unique<EmulatedPort>(std::move(line), TwoWayLink(*link, 0, kLinkRoom));
  };
}

}  // namespace feltwire
