#pragma once
// Advice about the geometry and the moving bodies of a scene.

#include <string>
#include <vector>

#include "sim/studies/advise/scene_facts.hpp"

namespace feltwire::advise {

/// A sentence for each thing that the scene has: the recommended geometry and MuJoCo tick, with the
/// reason. The numbers are those of docs/lab/trade.md and docs/lab/benchmarks.md.
std::vector<std::string> scene_advice(const SceneFacts& facts);

}  // namespace feltwire::advise
