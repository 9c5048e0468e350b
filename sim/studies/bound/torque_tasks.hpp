#pragma once
// The tasks for torque: stops of a joint, and bodies in the hand.

#include <memory>
#include <string>
#include <vector>

#include "sim/measure/six_dof.hpp"

namespace feltwire {

struct TorqueTask {
  std::string name;                      // one word
  PoseEnvironment touch{};               // in a fresh state
  std::shared_ptr<const Scene> scene{};  // of a tool with a body; null: a joint's stop
  HandTask hand{};                       // `depth` as set by press()
  WristTask wrist{};
  bool pressed = false;   // with 3 N, by press()
  double duration = 3.0;  // [s]
};

/// The stops of a joint, of `stiffness` [N m/rad] each: the hand's turn is the rotation vector from
/// the identity, [rad].
/// end_stop       a screw that is turned in until it is tight, half way of the wrist's turn
/// cone           a ball joint that leans against its stop all round: the paper's sphere, turned
/// cone_friction  the same with viscous friction along the stop: the paper's wall, turned
std::vector<TorqueTask> joint_tasks(double stiffness);

/// Bodies in the hand; docs/lab/torque.md has their sizes.
/// press, screwdriver, rock, scrape   a brick on a table
/// roll                               a round bar along an edge
/// peg                                a round peg into a ring, 0.5 mm of play all round
std::vector<TorqueTask> body_tasks();

/// Lets the hand press with 3 N where the task wants it pressed.
void press(TorqueTask& task, const Hand& hand);

}  // namespace feltwire
