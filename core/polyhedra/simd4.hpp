#pragma once
// Four numbers computed together, in the widest registers that the machine has.

#include <array>
#include <cstddef>

namespace feltwire {

/// May lie on doubles.
using Double4 = double __attribute__((vector_size(32), may_alias));
inline constexpr std::size_t kSimdLanes = 4;
/// With room for the copies that pad() appends.
template <std::size_t Most>
using PaddedNumbers = std::array<double, Most + kSimdLanes>;
/// Copies the last of `count` numbers behind it until there are whole fours of them.
template <class Numbers>
void pad(Numbers& numbers, std::size_t count) noexcept {
  for (std::size_t i = count; i % kSimdLanes != 0; ++i) numbers[i] = numbers[count - 1];
}

/// The function normal . x - offset.
struct LinearFunction {
  double x, y, z, offset;
};

/// A function with this is compiled twice, also for processors with AVX2; the program chooses when
/// it starts. Both do the same operations in the same order, without fused ones, so that they give
/// the same bits. Not under sanitizers, which cannot look into the choice.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FELTWIRE_ALSO_AVX2 __attribute__((target_clones("avx2", "default")))
#else
#define FELTWIRE_ALSO_AVX2
#endif

}  // namespace feltwire
