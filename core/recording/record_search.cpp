#include "core/recording/record_search.hpp"

#include <algorithm>

namespace feltwire::mcap {
namespace {

bool is_known(std::uint8_t opcode) {
  return (opcode >= static_cast<std::uint8_t>(Opcode::header) &&
          opcode <= static_cast<std::uint8_t>(Opcode::data_end)) ||
         opcode >= 0x80;  // opcodes of other programs
}

/// Returns true if a chunk must not contain a record of this type. After damage, the search stops
/// only at such a record. So the search never takes a record out of a damaged chunk.
bool is_outside_of_chunks(Opcode opcode) {
  return opcode == Opcode::chunk || opcode == Opcode::message_index ||
         opcode == Opcode::attachment || opcode == Opcode::metadata || opcode == Opcode::data_end;
}

bool has_known_fields(Opcode opcode) {
  return opcode == Opcode::header || opcode == Opcode::metadata || opcode == Opcode::schema ||
         opcode == Opcode::channel || opcode == Opcode::message_index ||
         opcode == Opcode::attachment || opcode == Opcode::chunk;
}

}  // namespace

bool is_filled(Opcode opcode, std::string_view record) {
  Cursor content(record);
  constexpr std::size_t kNumber = sizeof(std::uint64_t), kId = sizeof(std::uint16_t);
  constexpr std::size_t kCrc = sizeof(std::uint32_t);
  const auto skip_texts = [&](int count) {
    for (int i = 0; i < count; ++i) content.text();
  };
  switch (opcode) {
    case Opcode::header:
    case Opcode::metadata:
      skip_texts(2);
      break;
    case Opcode::schema:
      content.bytes(kId);
      skip_texts(3);
      break;
    case Opcode::channel:
      content.bytes(2 * kId);
      skip_texts(3);
      break;
    case Opcode::message_index:
      content.bytes(kId);
      skip_texts(1);
      break;
    case Opcode::attachment:
      content.bytes(2 * kNumber);
      skip_texts(2);
      content.bytes(content.number<std::uint64_t>());
      content.bytes(kCrc);
      break;
    case Opcode::chunk:
      content.bytes(3 * kNumber + kCrc);
      skip_texts(1);
      content.bytes(content.number<std::uint64_t>());
      break;
    default:
      return true;
  }
  return content.ok() && content.rest().empty();
}

RecordSearch::RecordSearch(std::istream& file, ReaderLimits limits) : file_(file), limits_(limits) {
  file_.clear();
  file_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file_.tellg()));
}

std::string RecordSearch::bytes(std::uint64_t begin, std::uint64_t end) {
  std::string out(static_cast<std::size_t>(std::min(end, size_) - std::min(begin, size_)), '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(begin));
  file_.read(out.data(), static_cast<std::streamsize>(out.size()));
  out.resize(static_cast<std::size_t>(file_.gcount()));
  return out;
}

std::optional<RecordHead> RecordSearch::head_at(std::uint64_t at) {
  if (at > size_ || size_ - at < kRecordHead) return std::nullopt;
  const std::string raw = bytes(at, at + kRecordHead);
  Cursor head(raw);
  const auto opcode = head.number<std::uint8_t>();
  const auto length = head.number<std::uint64_t>();
  if (!head.ok() || !is_known(opcode) || length > limits_.record ||
      length > size_ - at - kRecordHead)
    return std::nullopt;
  return RecordHead{static_cast<Opcode>(opcode), at + kRecordHead + length};
}

bool RecordSearch::is_record_at(std::uint64_t at) {
  constexpr std::uint64_t kDataEnd = kRecordHead + 4;
  if (at == size_) return true;
  const auto head = head_at(at);
  if (!head) return false;
  if (head->opcode == Opcode::data_end) return head->end - at == kDataEnd;
  if (has_known_fields(head->opcode)) {
    const std::string record = bytes(at, head->end);
    return is_filled(head->opcode, std::string_view(record).substr(kRecordHead));
  }
  if (size_ - head->end <= kRecordHead || head_at(head->end)) return true;
  const std::string cut = bytes(head->end, head->end + kRecordHead);
  Cursor next(cut);
  return is_known(next.number<std::uint8_t>()) && next.number<std::uint64_t>() <= limits_.record;
}

std::uint64_t RecordSearch::next_after(std::uint64_t at) {
  constexpr std::uint64_t kBlock = 1 << 20;
  for (std::uint64_t block = at; block < size_; block += kBlock) {
    const std::string here = bytes(block, block + kBlock);
    for (std::size_t i = 0; i < here.size(); ++i) {
      const auto opcode = static_cast<Opcode>(static_cast<std::uint8_t>(here[i]));
      if (!is_outside_of_chunks(opcode)) continue;
      // The upper bytes of every possible length are zero.
      constexpr std::size_t kUpper = 8;
      if (i + kUpper < here.size() && here[i + kUpper] != '\0') continue;
      if (is_record_at(block + i)) return block + i;
    }
  }
  return size_;
}

}  // namespace feltwire::mcap
