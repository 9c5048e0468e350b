#pragma once
// The number of smaller units in one larger unit, for text that people read.

namespace feltwire {

inline constexpr double kPercent = 100.0, kMilli = 1e3, kMicro = 1e6;

}  // namespace feltwire
