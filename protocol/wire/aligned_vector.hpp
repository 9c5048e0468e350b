#pragma once

#include <cstdint>

#include "flatbuffers/flatbuffers.h"

namespace feltwire {

/// Whether the elements of a verified vector can be read in place. FlatBuffers' verifier checks the
/// alignment of fields and of a vector's length, but not that of the elements.
template <class Value>
bool aligned(const flatbuffers::Vector<Value>& vector, std::size_t alignment) noexcept {
  return vector.size() == 0 || reinterpret_cast<std::uintptr_t>(vector.Data()) % alignment == 0;
}

}  // namespace feltwire
