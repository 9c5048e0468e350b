#pragma once
// Seeds of tests that try what is random. The fixed ones are the same in every run, so that what
// they find is found again; the fresh ones are others in every run, so that runs find more in time.
// A program that uses fresh ones prints "FELTWIRE_SEED=...": the same tests with that in the
// environment try the same again. RapidCheck's properties: tests/CMakeLists.txt.

#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "core/base/splitmix.hpp"

namespace feltwire::test {

/// Of this run of the program: FELTWIRE_SEED where it is given, else random. Printed once.
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

/// The number of rounds of a test that could go on for ever: `whole`, or a tenth under a sanitizer.
/// There a round takes ten times as long, and the numbers do not matter.
template <std::integral Count>
constexpr Count rounds(Count whole) {
#ifdef FELTWIRE_SANITIZED
  return (whole + 9) / 10;
#else
  return whole;
#endif
}

/// `first`, `first` + 1, ..., `fixed` of them, and then `fresh` that are others in every run. Under
/// a sanitizer a tenth of the fixed ones.
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
