#pragma once
// Internal to the MCAP reader and writer: numbers and texts, to bytes and back.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/little_endian.hpp"

namespace feltwire::mcap {

template <class Unsigned>
void put(std::string& out, Unsigned value) {
  std::array<std::uint8_t, sizeof(Unsigned)> bytes;
  put_little_endian(bytes.data(), value);
  out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// With a length before it, as in texts, maps and arrays.
inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

template <class Unsigned>
Unsigned get(std::string_view bytes) {
  return get_little_endian<Unsigned>(reinterpret_cast<const std::uint8_t*>(bytes.data()));
}

/// Takes values off the front of bytes. A value that does not fit is zero or empty, and ok() is
/// false.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  std::string_view bytes(std::uint64_t size) {
    if (size > rest_.size()) ok_ = false;
    if (!ok_) return {};
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(size));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  template <class Unsigned>
  Unsigned number() {
    const std::string_view taken = bytes(sizeof(Unsigned));
    return taken.empty() ? Unsigned{0} : get<Unsigned>(taken);
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }

  std::string_view rest() const { return rest_; }
  bool empty() const { return !ok_ || rest_.empty(); }
  bool ok() const { return ok_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace feltwire::mcap
