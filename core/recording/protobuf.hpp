#pragma once
// The part of Protobuf's encoding that recordings need (protobuf.dev/programming-guides/encoding):
// fields are written in order and read in any order.

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace feltwire::protobuf {

void put_varint(std::string& out, std::uint64_t value);

/// A field of a number. As in proto3, a zero is not written unless the field is `optional`.
void put(std::string& out, std::uint32_t field, double value);
void put(std::string& out, std::uint32_t field, std::uint64_t value);
void put_optional(std::string& out, std::uint32_t field, double value);
/// A field of type fixed64.
void put_fixed(std::string& out, std::uint32_t field, std::uint64_t value);
/// A field of text or bytes.
void put(std::string& out, std::uint32_t field, std::string_view text);

/// A field that is a message, whose fields `fill(out)` appends.
template <class Fill>
void put_message(std::string& out, std::uint32_t field, Fill fill) {
  constexpr std::uint64_t kLengthDelimited = 2, kOneByte = 128;
  put_varint(out, field << 3 | kLengthDelimited);
  const std::size_t length_at = out.size();
  out += '\0';
  fill(out);
  const std::uint64_t length = out.size() - length_at - 1;
  if (length < kOneByte) {
    out[length_at] = static_cast<char>(length);
    return;
  }
  std::string varint;
  put_varint(varint, length);
  out.replace(length_at, 1, varint);
}

struct Field {
  std::uint32_t number = 0;
  std::uint64_t value = 0;   // of a varint, a fixed64 or a fixed32
  std::string_view bytes{};  // of text, bytes or a message
  bool is_fixed64 = false, is_bytes = false;
  double real() const { return std::bit_cast<double>(value); }
};

/// Takes the fields of a message one by one.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}
  /// Empty at the end, and at bytes that are no field.
  std::optional<Field> next();
  /// Whether all bytes so far were fields.
  bool ok() const { return ok_; }

 private:
  std::optional<std::uint64_t> varint();

  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace feltwire::protobuf
