#pragma once

#include <chrono>
#include <cmath>

namespace feltwire {

using Nanoseconds = std::chrono::nanoseconds;
inline double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }
inline Nanoseconds from_seconds(double time) { return Nanoseconds(std::llround(time * 1e9)); }

}  // namespace feltwire
