#pragma once
// Which features a scene needs, and which of its parts need them: for people who ask what it costs.

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire {

struct FeatureCost {
  std::string what;                 // "stick points"
  std::string cost;                 // what it makes a sample do, or what is kept for it
  std::vector<std::string> needed;  // names of the objects and guides that ask for it
};

/// Every feature that a scene may need, with the parts that need it. A feature without such parts
/// is neither allocated, stepped nor sent.
std::vector<FeatureCost> feature_costs(const Scene& scene);

/// The same for people: a line for each need, with names, and one for all that nothing is spent on.
std::string describe_costs(const Scene& scene);

}  // namespace feltwire
