#include "client/device/connection_lag.hpp"

#include <string>

namespace feltwire {

void assume_lag(SourcedSpec& described, const Connection& connection) {
  DeviceSpec& spec = described.spec;
  if (described.tells_lag || spec.actuation.late_ticks > 0) return;
  spec.actuation.lag = connection.lag;
  spec.actuation.kind = LagKind::delay;
  described.sources["actuation_lag"] = "assumption for " + std::string(connection.name);
}

}  // namespace feltwire
