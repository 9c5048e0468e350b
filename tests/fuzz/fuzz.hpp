#pragma once
// Shared by the fuzz targets: the fuzzed function, invariants, and values from bytes.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "core/base/types.hpp"
#include "protocol/wire/datagram.hpp"

/// Runs an input; an error ends the program. libFuzzer defines name and linkage.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace feltwire::fuzz {

/// An invariant of a target: a violation ends the program like a crash.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "invariant broken: %s\n", what);
  std::abort();
}

/// Bytes as text.
inline std::string text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Requires a message about a file to be a line "FILE:LINE: ...".
inline void require_place(std::string_view message, std::string_view file) {
  require(message.starts_with(file) && message.size() > file.size() + 1 &&
              message[file.size()] == ':' && message[file.size() + 1] >= '1' &&
              message[file.size() + 1] <= '9',
          "an error names its file and line");
}

/// Takes values from the front of an input; zeros when it is used up. (LLVM's FuzzedDataProvider
/// comes with clang only, but every compiler plays the corpora.)
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  bool empty() const { return rest_.empty(); }
  std::size_t size() const { return rest_.size(); }

  Bytes bytes(std::size_t most) {
    const Bytes taken = rest_.first(std::min(most, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  template <class Unsigned>
  Unsigned whole() {
    Unsigned value = 0;
    const Bytes taken = bytes(sizeof value);
    if (!taken.empty()) std::memcpy(&value, taken.data(), taken.size());
    return value;
  }
  std::uint8_t byte() { return whole<std::uint8_t>(); }
  bool coin() { return (byte() & 1u) != 0; }

  /// Any double, or a double from any float.
  double any_double() { return std::bit_cast<double>(whole<std::uint64_t>()); }
  double any_float() { return static_cast<double>(std::bit_cast<float>(whole<std::uint32_t>())); }
  /// From -size to size, in steps that float32 represents.
  double number(double size) {
    constexpr double kSteps = 32768.0;
    return size * static_cast<double>(static_cast<std::int16_t>(whole<std::uint16_t>())) / kSteps;
  }
  Vec3 vector(double size) {
    const double x = number(size), y = number(size), z = number(size);
    return {x, y, z};
  }

 private:
  Bytes rest_;
};

/// Equal bits, including NaN and the sign of zero.
inline bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
inline bool same(const Vec3& a, const Vec3& b) {
  return same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
}
inline bool same(const Command& a, const Command& b) {
  return same(a.elastic, b.elastic) && same(a.frictional, b.frictional) && same(a.torque, b.torque);
}
inline bool same(const Quaternion& a, const Quaternion& b) {
  return same(a.w(), b.w()) && same(Vec3(a.vec()), Vec3(b.vec()));
}

}  // namespace feltwire::fuzz
