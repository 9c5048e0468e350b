#pragma once
// The robots that feltwire-follower can move.

#include <memory>
#include <optional>
#include <string>

#include "core/base/types.hpp"
#include "core/teleoperation/follower.hpp"
#include "core/teleoperation/surface_model.hpp"

namespace feltwire {

/// The choice on the command line; exactly one of the three files is given.
struct RobotChoice {
  std::string surroundings;  // FILE.json: a point robot in that scene
  std::string arm;           // FILE.xml: the arm of that MJCF
  std::string socket;        // PATH where the driver of a robot connects
  std::optional<Vec3> at;    // [m] start of a simulated robot
};

/// Throws std::invalid_argument that names the contradicting options, and the remedy.
void check(const RobotChoice& choice);

/// Loads the surfaces that the robot may touch from a scene file. Throws FileError and
/// std::invalid_argument naming the file and the remedy.
std::shared_ptr<SurfaceModel> load_surfaces(const std::string& file);

/// Makes the robot. The arm goes to `at` first. Waits for a driver for `patience` [s], and says on
/// standard error that it does. Throws FileError, std::invalid_argument and std::runtime_error,
/// each with the remedy. Precondition: check().
std::unique_ptr<Follower> make_robot(const RobotChoice& choice, double patience);

}  // namespace feltwire
