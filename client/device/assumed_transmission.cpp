#include "client/device/assumed_transmission.hpp"

#include <string>

namespace feltwire {

void assume_transmission(SourcedSpec& described, const Drive& drive) {
  DeviceSpec& spec = described.spec;
  if (described.tells_transmission || spec.transmission.encoder_side == EncoderSide::handle) return;
  spec.transmission.stiffness = drive.stiffness;
  const std::string source = "assumption for " + std::string(drive.name);
  described.sources["transmission_stiffness"] = source + " with its encoder at the motor";
  described.sources["encoder_side"] = source;
}

}  // namespace feltwire
