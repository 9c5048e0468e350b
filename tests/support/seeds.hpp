#pragma once
// Seeds of random tests. Fixed seeds are equal in every run, so a failure repeats. Fresh seeds
// differ in every run, so more runs find more. A program with fresh seeds prints
// "FELTWIRE_SEED=...": set this in the environment to repeat its tests. RapidCheck's properties:
// tests/CMakeLists.txt.

#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "core/base/splitmix.hpp"

namespace feltwire::test {

/// The seed of this run of the program: FELTWIRE_SEED if given, otherwise random. Printed once.
inline std::uint64_t run_seed() {
  static const std::uint64_t seed = [] {
    const char* const given = std::getenv("FELTWIRE_SEED");
    const std::uint64_t chosen =
        given != nullptr ? std::stoull(given) : std::uint64_t{std::random_device{}()};
    std::cout << "FELTWIRE_SEED=" << chosen << " repeats the random part of this run" << std::endl;
    return chosen;
  }();
  return seed;
}

/// The number of rounds of an open-ended test: `whole`, or a tenth under a sanitizer. There a round
/// takes ten times as long, and the numbers do not matter.
template <std::integral Count>
constexpr Count rounds(Count whole) {
#ifdef FELTWIRE_SANITIZED
  return (whole + 9) / 10;
#else
  return whole;
#endif
}

/// `fixed` seeds from `first` on, then `fresh` seeds that differ in every run. A sanitizer uses a
/// tenth of the fixed seeds and no fresh ones.
inline std::vector<std::uint64_t> seeds(std::uint64_t first, std::uint64_t fixed,
                                        std::uint64_t fresh) {
  fixed = rounds(fixed);
#ifdef FELTWIRE_SANITIZED
  fresh = 0;
#endif
  std::vector<std::uint64_t> all;
  for (std::uint64_t n = 0; n < fixed; ++n) all.push_back(first + n);
  for (std::uint64_t n = 0; n < fresh; ++n) all.push_back(splitmix::draw(run_seed(), n));
  return all;
}

}  // namespace feltwire::test
