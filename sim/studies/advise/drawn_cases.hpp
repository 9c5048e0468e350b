#pragma once
// Devices, links, scenes and hands that are drawn, to check the advice on what it has not seen.

#include <cstdint>
#include <string>
#include <vector>

#include "client/hands/hand.hpp"
#include "core/device/device_spec.hpp"
#include "sim/studies/advise/scene_facts.hpp"

namespace feltwire::advise {

struct DrawnCase {
  std::uint64_t seed = 0;
  DeviceSpec device;
  std::string link;  // for parse_link()
  Scene scene;
  std::vector<Place> places;  // one on each object, where a hand presses
  Hand hand;                  // the true one, which the advice does not know
  double lead_in = 1.0;       // [s] of its approach
};

/// Draws a case; the same seed gives the same one. docs/lab/advise.md has the ranges.
DrawnCase drawn_case(std::uint64_t seed);

/// `count` cases: seed, seed + 1, ...
std::vector<DrawnCase> drawn_cases(std::uint64_t seed, int count);

}  // namespace feltwire::advise
