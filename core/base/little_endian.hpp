#pragma once
// Numbers of the headers, byte by byte: no struct is ever cast from a datagram.

#include <cstddef>
#include <cstdint>

namespace feltwire {

template <class Unsigned>
void put_little_endian(std::uint8_t* at, Unsigned value) noexcept {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
    at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

template <class Unsigned>
Unsigned get_little_endian(const std::uint8_t* at) noexcept {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
    value = static_cast<Unsigned>(value | static_cast<Unsigned>(at[i]) << (8 * i));
  return value;
}

}  // namespace feltwire
