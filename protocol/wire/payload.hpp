#pragma once
// Internal to the codecs: the buffer of a payload under construction, and the bytes of a received
// one.

#include <array>
#include <cstdint>
#include <cstring>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/codec.hpp"

namespace feltwire {

// A datagram is one table and its vectors; a payload that claims more is invalid.
inline constexpr flatbuffers::uoffset_t kMaxDepth = 4, kMaxTables = 5;
inline constexpr std::size_t kSmallestBuffer = 8;  // [bytes] a root offset and an empty table

/// A payload that can be read in place: FlatBuffers reads eight bytes at a time.
class Aligned {
 public:
  explicit Aligned(Bytes payload) noexcept : data_(payload.data()), size_(payload.size()) {
    if (size_ > copy_.size()) {
      size_ = 0;
    } else if (reinterpret_cast<std::uintptr_t>(data_) % alignof(std::uint64_t) != 0) {
      std::memcpy(copy_.data(), data_, size_);
      data_ = copy_.data();
    }
  }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;

  /// The verified root, or null. The size is checked first, because the verifier asserts on sizes
  /// out of range.
  template <class Table>
  const Table* root() const noexcept {
    if (size_ < kSmallestBuffer) return nullptr;
    flatbuffers::Verifier verifier(data_, size_, kMaxDepth, kMaxTables);
    if (!verifier.VerifyBuffer<Table>(nullptr)) return nullptr;
    return flatbuffers::GetRoot<Table>(data_);
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  alignas(std::uint64_t) std::array<std::uint8_t, kMaxDatagram> copy_;  // written when needed
};

struct Encoder::Builder {
  // Twice the size: the fields of a table under construction are at the buffer's other end.
  flatbuffers::FlatBufferBuilder payload{2 * kMaxDatagram};

  /// FlatBuffers allocates its buffer with the first byte. That happens here, where a failure is
  /// allowed, and not in the first datagram.
  Builder() { payload.PushElement(std::uint8_t{0}); }

  /// Clears it for the next payload; keeps its buffer.
  flatbuffers::FlatBufferBuilder& begin() {
    payload.Clear();
    return payload;
  }
  template <class Table>
  Bytes finish(flatbuffers::Offset<Table> root) {
    payload.Finish(root);
    return {payload.GetBufferPointer(), payload.GetSize()};
  }
};

}  // namespace feltwire
