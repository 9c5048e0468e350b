#pragma once
// What a scene needs, and which of its parts need it: for people who wonder what it costs.

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire {

struct Need {
  std::string what;                 // "stick points"
  std::string cost;                 // what it makes a sample do, or what is kept for it
  std::vector<std::string> needed;  // names of the objects and guides that ask for it
};

/// Everything that a scene may need; what nobody asks for is there with nobody, and is neither
/// allocated, stepped nor sent.
std::vector<Need> needs(const Scene& scene);

/// The same for people: a line for each need, with names, and one for all that nothing is spent on.
std::string explain(const Scene& scene);

}  // namespace feltwire
