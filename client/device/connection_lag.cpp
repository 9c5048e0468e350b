#include "client/device/connection_lag.hpp"

#include <string>

namespace feltwire {

void assume_lag(SourcedSpec& described, const Connection& connection) {
  DeviceSpec& spec = described.spec;
  if (described.tells_lag || spec.late_ticks > 0) return;
  spec.actuation_lag = connection.lag;
  spec.actuation_kind = LagKind::delay;
  described.sources["actuation_lag"] = "assumption for " + std::string(connection.name);
}

}  // namespace feltwire
