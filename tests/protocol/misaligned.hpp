#pragma once
// A FlatBuffer with misaligned numbers that its verifier accepts.

#include <cstring>
#include <vector>

#include "flatbuffers/flatbuffers.h"

namespace feltwire::test {

/// The buffer with a copy of a field's vector (`bytes` of elements) after its end, four bytes off
/// the alignment of eight. The field points to the copy.
template <class Table>
std::vector<std::uint8_t> with_misaligned_vector(std::vector<std::uint8_t> buffer,
                                                 const std::uint8_t* original, const Table* table,
                                                 flatbuffers::voffset_t field, std::size_t bytes) {
  const auto* plain = reinterpret_cast<const flatbuffers::Table*>(table);
  const auto at = static_cast<std::size_t>(plain->GetAddressOf(field) - original);
  const std::size_t from = at + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(&buffer[at]);
  buffer.resize((buffer.size() + 7) / 8 * 8);  // the length begins at 0 of 8, the elements at 4
  const std::size_t to = buffer.size();
  buffer.resize(to + sizeof(flatbuffers::uoffset_t) + bytes);
  std::memcpy(&buffer[to], &buffer[from], sizeof(flatbuffers::uoffset_t) + bytes);
  flatbuffers::WriteScalar(&buffer[at], static_cast<flatbuffers::uoffset_t>(to - at));
  return buffer;
}

}  // namespace feltwire::test
