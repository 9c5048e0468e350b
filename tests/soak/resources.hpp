#pragma once
// The resources of this process, as the kernel and the allocator report them.

#include <cstddef>

namespace feltwire::soak {

/// [bytes] resident memory.
std::size_t resident_memory();
/// [bytes] that all threads have allocated and not yet freed.
std::size_t heap_in_use();
/// The number of open descriptors.
std::size_t descriptors();

}  // namespace feltwire::soak
