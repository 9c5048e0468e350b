#pragma once
// The tick of hands that move in virtual time.

namespace feltwire::testing {

inline constexpr double kTick = 1e-3;  // [s]

}  // namespace feltwire::testing
