#include "core/recording/protobuf.hpp"

#include "core/recording/mcap_bytes.hpp"

namespace feltwire::protobuf {
namespace {

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };
constexpr std::uint32_t kTypeBits = 3;

void put_tag(std::string& out, std::uint32_t field, WireType type) {
  put_varint(out, field << kTypeBits | type);
}

}  // namespace

void put_varint(std::string& out, std::uint64_t value) {
  constexpr std::uint64_t kMore = 0x80;
  for (; value >= kMore; value >>= 7) out += static_cast<char>(value | kMore);
  out += static_cast<char>(value);
}

void put(std::string& out, std::uint32_t field, double value) {
  // Omit only +0, which has no bits set. -0 is a different number.
  if (std::bit_cast<std::uint64_t>(value) != 0) put_optional(out, field, value);
}

void put_fixed(std::string& out, std::uint32_t field, std::uint64_t value) {
  put(out, field, std::bit_cast<double>(value));
}

void put_optional(std::string& out, std::uint32_t field, double value) {
  put_tag(out, field, kFixed64);
  mcap::put(out, std::bit_cast<std::uint64_t>(value));
}

void put(std::string& out, std::uint32_t field, std::uint64_t value) {
  if (value == 0) return;
  put_tag(out, field, kVarint);
  put_varint(out, value);
}

void put(std::string& out, std::uint32_t field, std::string_view text) {
  if (text.empty()) return;
  put_tag(out, field, kBytes);
  put_varint(out, text.size());
  out += text;
}

std::optional<std::uint64_t> Fields::varint() {
  constexpr int kBits = 64;
  std::uint64_t value = 0;
  for (int shift = 0; shift < kBits && !rest_.empty(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    value |= static_cast<std::uint64_t>(byte & 0x7fu) << shift;
    if (byte < 0x80u) return value;
  }
  ok_ = false;
  return std::nullopt;
}

std::optional<Field> Fields::next() {
  if (!ok_ || rest_.empty()) return std::nullopt;
  const auto tag = varint();
  if (!tag) return std::nullopt;
  constexpr std::uint64_t kLargestTag = 0xffffffffu;
  const std::uint64_t number = *tag >> kTypeBits;
  ok_ = *tag <= kLargestTag && number > 0;
  Field field{.number = static_cast<std::uint32_t>(number)};
  mcap::Cursor rest(rest_);
  switch (*tag & 7u) {
    case kVarint:
      field.value = varint().value_or(0);
      return ok_ ? std::optional(field) : std::nullopt;
    case kFixed64:
      field.value = rest.number<std::uint64_t>();
      field.is_fixed64 = true;
      break;
    case kFixed32:
      field.value = rest.number<std::uint32_t>();
      break;
    case kBytes: {
      const auto size = varint();
      rest = mcap::Cursor(rest_);
      field.bytes = rest.bytes(size.value_or(0));
      field.is_bytes = true;
      break;
    }
    default:  // Refuse groups, because they are obsolete.
      ok_ = false;
  }
  ok_ = ok_ && rest.ok();
  rest_ = rest.rest();
  return ok_ ? std::optional(field) : std::nullopt;
}

}  // namespace feltwire::protobuf
