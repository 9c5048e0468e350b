#pragma once
// The tasks of the bench of three degrees of freedom, and their measures.

#include <string_view>
#include <vector>

#include "sim/studies/teleop/space_bench.hpp"
#include "sim/studies/teleop/tasks.hpp"

namespace feltwire::teleop::in_space {

struct SpaceTask {
  std::string_view name;
  SpaceSetup setup;
  Window window;  // of the measures
};

/// sphere: around a ball with friction; peg: into a hole, beside its axis, down to its ground.
const std::vector<SpaceTask>& space_tasks();

/// Judges a run of a task. The force error of the sphere is against the series spring without
/// delay, which a proxy with the friction of the shape draws to the surface. That of the peg is
/// against the force on the robot at the same time: a proxy at the hand's place may miss the hole
/// that a robot behind it finds.
Measured judge(const SpaceTask& task, const std::vector<SpaceSample>& samples);

}  // namespace feltwire::teleop::in_space
