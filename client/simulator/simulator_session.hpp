#pragma once
// A session of a hand with a simulator in the same process.

#include <memory>

#include "client/run/run_client.hpp"
#include "client/simulator/simulator_feed.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// The scene, as a server would describe it.
struct SimulatorScene {
  double stiffness = 0.0;              // [N/m] of the stiffest surface, > 0
  Vec3 start_position = Vec3::Zero();  // [m] where a hand begins: on a surface
  Vec3 start_normal = Vec3::UnitZ();   // unit normal of the surface there
};

/// Makes a run of these options meet a simulator in place of a server: sets what joins the scene,
/// and the port. Returns the way for the contacts. The client bounds, and computes the contact
/// between two answers itself. Throws std::invalid_argument that names the parameter and the
/// remedy.
std::shared_ptr<SimulatorFeed> meet_simulator(RunOptions& options, const SimulatorScene& scene);

}  // namespace feltwire
