#pragma once
// The scene and the configuration of the servers that tests of clients start.

#include <string>

#include "server/app/server.hpp"

namespace feltwire::testing {

inline Scene floor_scene() {
  Object plane;
  plane.name = "floor";
  plane.shape = Plane{};
  plane.material = {.stiffness = 500.0, .static_friction = 0.4, .dynamic_friction = 0.3};
  return Scene("floor", {plane});
}

inline ServerConfig any_ports() {
  ServerConfig config;
  config.port = 0;
  config.log.level = "off";
  return config;
}

}  // namespace feltwire::testing
