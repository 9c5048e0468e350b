#pragma once
// The costs of a scene: its features, and the parts that need them.

#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire {

struct FeatureCost {
  std::string what;                 // "stick points"
  std::string cost;                 // the work of a sample, or the memory that is kept
  std::vector<std::string> needed;  // names of the objects, guides and tools that need it
};

/// All features that a scene can need, each with the parts that need it. A feature that no part
/// needs is neither allocated, stepped nor sent.
std::vector<FeatureCost> feature_costs(const Scene& scene);

/// An object that the start of a scene lies in.
struct StartInside {
  std::string object;
  double depth = 0.0;  // [m]
};
/// The deepest. Empty if the start lies on surfaces or outside of all objects.
std::optional<StartInside> start_inside(const Scene& scene);

/// The size of each object, whether the start lies inside of one, and the costs: one line for each
/// feature that is needed, and one that lists all others.
std::string describe_costs(const Scene& scene);

}  // namespace feltwire
