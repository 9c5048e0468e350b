#pragma once
// A FlatBuffer that its verifier takes, with numbers where no number may lie.

#include <cstring>
#include <vector>

#include "flatbuffers/flatbuffers.h"

namespace feltwire::test {

/// The buffer with a copy of the vector of a table's field (`bytes` of elements) behind its end,
/// four bytes off the alignment of eight, and the field pointing there.
template <class Table>
std::vector<std::uint8_t> with_misaligned_vector(std::vector<std::uint8_t> buffer,
                                                 const std::uint8_t* original, const Table* table,
                                                 flatbuffers::voffset_t field, std::size_t bytes) {
  const auto* plain = reinterpret_cast<const flatbuffers::Table*>(table);
  const auto at = static_cast<std::size_t>(plain->GetAddressOf(field) - original);
  const std::size_t from = at + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(&buffer[at]);
  buffer.resize((buffer.size() + 7) / 8 * 8);  // the length lies at 0 of 8, the elements at 4
  const std::size_t to = buffer.size();
  buffer.resize(to + sizeof(flatbuffers::uoffset_t) + bytes);
  std::memcpy(&buffer[to], &buffer[from], sizeof(flatbuffers::uoffset_t) + bytes);
  flatbuffers::WriteScalar(&buffer[at], static_cast<flatbuffers::uoffset_t>(to - at));
  return buffer;
}

}  // namespace feltwire::test
