#pragma once
// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014): a
// mixing function of a counter. It gives the same numbers on every machine, which the standard
// library's distributions do not promise. Draw i does not need the draws before it.

#include <cstdint>

namespace feltwire::splitmix {

inline constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15ULL;

constexpr std::uint64_t mix(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

/// Draw i = 0, 1, ... of the generator with this seed.
constexpr std::uint64_t draw(std::uint64_t seed, std::uint64_t i) noexcept {
  return mix(seed + (i + 1) * kStep);
}

}  // namespace feltwire::splitmix
