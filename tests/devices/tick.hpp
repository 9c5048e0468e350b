#pragma once
// The tick of the hands that tests move in virtual time.

namespace feltwire::testing {

inline constexpr double kTick = 1e-3;  // [s]

}  // namespace feltwire::testing
