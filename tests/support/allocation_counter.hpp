#pragma once
// Counts what the whole program allocates. Replaces the global operator new, which does nothing
// useful under sanitizers: skip such tests there.

#include <cstddef>

namespace feltwire::test {

/// Allocations of the calling thread so far.
std::size_t allocations();

}  // namespace feltwire::test
