#pragma once
// How many of a smaller unit make one larger unit, for text that people read.

namespace feltwire {

inline constexpr double kPercent = 100.0, kMilli = 1e3, kMicro = 1e6;

}  // namespace feltwire
