#pragma once
// The contacts of one tool with the moving objects of a world.

#include <cstdint>
#include <vector>

#include "core/dynamics/hand_speed_limit.hpp"
#include "core/dynamics/neighbour_list.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

/// The state of a moving object for a tool: too far to be in the tool's list of neighbours, in the
/// list, or in the list and evaluated at the tool's last sample.
enum class NeighbourState : std::uint8_t { far, near, asked };

/// The largest recent force with which a hand pushed an object.
struct PeakPush {
  double force = 0.0;      // [N]
  std::uint64_t step = 0;  // of the world, then
};

/// The contacts of one tool with the moving objects after its last sample.
struct BodyContactState {
  std::size_t held = 0;  // the tool's place in Scene::views()
  Tool tool;
  std::vector<Vec3> forces;  // [N] on the hand, one for each moving object
  NeighbourList
      near;  // of a point or a ball: only these objects are evaluated; others give no force
  std::vector<NeighbourState> nearness;  // of a point or a ball: one for each moving object
  bool fresh = false;                    // made by the newest sample, with no step since
  std::uint64_t resets = 0;              // the world's, when the contact memory was last valid
  std::uint64_t steps = 0;               // the world's, when it was last asked
  double most_force = HandLimits::kOff;  // [N] limit, on all moving objects together
  HandSpeedLimit pace;
  bool placed = false;                // a sample has come
  std::vector<PeakPush> peak_pushes;  // one for each moving object

  // The rest is for a tool with a body. `tool` is then the pose at which the contacts hold it.
  Pose device;                        // the pose of the device
  std::vector<Vec3> torques;          // [N m] on the hand, about the tool's position
  std::vector<ObjectMotion> motions;  // of all objects, since it was last asked
  double ahead = 0.0;                 // [s] that the tool went through since the hand's last sample
};

/// The time and the other values of a world that its contacts depend on.
struct WorldMoment {
  double tick = 0.0;            // [s] time of one step
  std::uint64_t steps = 0;      // as in WorldCounters
  std::uint64_t resets = 0;     // as in WorldCounters
  std::uint64_t now = 0;        // [ticks] the steps, and the ticks that passed without a step
  double trust = 1.0;           // 0 to 1: share of a moving object's force that is felt
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
};

}  // namespace feltwire
