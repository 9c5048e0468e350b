#include "client/transport/encoder.hpp"

#include <sstream>

namespace feltwire {

std::optional<double> encoder_stiffness_limit(const DeviceSpec& spec) {
  if (!(spec.position_resolution > 0.0)) return std::nullopt;
  return 2.0 * spec.coulomb_friction / spec.position_resolution;
}

std::optional<std::string> encoder_warning(const DeviceSpec& spec, double scene_stiffness) {
  const auto limit = encoder_stiffness_limit(spec);
  if (!limit || !(scene_stiffness > *limit)) return std::nullopt;
  std::ostringstream text;
  text << "the scene's stiffest surface, " << scene_stiffness << " N/m, is above the " << *limit
       << " N/m that the encoders of " << spec.name << " stand (2 x " << spec.coulomb_friction
       << " N of dry friction / a quantum of " << 1e6 * spec.position_resolution
       << " um), so it may buzz: soften it, or take a device with finer encoders or more friction";
  return text.str();
}

}  // namespace feltwire
