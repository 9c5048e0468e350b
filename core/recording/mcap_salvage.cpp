#include "core/recording/mcap_salvage.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <streambuf>
#include <string_view>

#include "core/base/file_error.hpp"
#include "core/recording/compression.hpp"
#include "core/recording/mcap_bytes.hpp"
#include "core/recording/record_search.hpp"

namespace feltwire::mcap {
namespace {

struct Range {
  std::uint64_t begin, end;
};

std::string record_of(Opcode opcode, std::string_view content) {
  std::string out;
  put(out, static_cast<std::uint8_t>(opcode));
  put(out, std::uint64_t{content.size()});
  out += content;
  return out;
}

/// Returns the message of a Reader's error, without the byte position and the advice.
std::string reason_of(const FileError& error) {
  std::string_view words = error.what();
  constexpr std::string_view kByte = ": byte ";
  if (const auto at = words.find(kByte); at != std::string_view::npos)
    if (const auto end = words.find(": ", at + kByte.size()); end != std::string_view::npos)
      words.remove_prefix(end + 2);
  return std::string(words.substr(0, words.find(';')));
}

}  // namespace

/// A stream of the bytes `head` and then of some ranges of the file.
class SalvagedFile::Parts final : public std::streambuf {
 public:
  explicit Parts(std::istream& file) : file_(file) {}

  std::string head;
  std::vector<Range> ranges;

 protected:
  int_type underflow() override {
    if (!head_read_) {
      head_read_ = true;
      setg(head.data(), head.data(), head.data() + head.size());
      if (!head.empty()) return traits_type::to_int_type(*gptr());
    }
    while (next_ < ranges.size() && at_ == ranges[next_].end) begin(next_ + 1);
    if (next_ == ranges.size()) return traits_type::eof();
    if (at_ == kBefore) at_ = ranges[next_].begin;
    const auto size = static_cast<std::streamsize>(
        std::min<std::uint64_t>(block_.size(), ranges[next_].end - at_));
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at_));
    file_.read(block_.data(), size);
    const std::streamsize got = file_.gcount();
    if (got <= 0) return traits_type::eof();
    at_ += static_cast<std::uint64_t>(got);
    setg(block_.data(), block_.data(), block_.data() + got);
    return traits_type::to_int_type(*gptr());
  }

 private:
  static constexpr std::uint64_t kBefore = std::numeric_limits<std::uint64_t>::max();
  void begin(std::size_t range) {
    next_ = range;
    at_ = range < ranges.size() ? ranges[range].begin : kBefore;
  }

  std::istream& file_;
  std::array<char, 1 << 16> block_{};
  bool head_read_ = false;
  std::size_t next_ = 0;
  std::uint64_t at_ = kBefore;
};

/// A pass over a file that finds its intact and its missing parts.
struct SalvagedFile::Scan {
  Scan(std::istream& in, ReaderLimits given) : file(in, given), limits(given), size(file.size()) {
    definitions = kMagic;
    std::string nothing;
    put_text(nothing, "");
    put_text(nothing, "");
    definitions += record_of(Opcode::header, nothing);
  }

  /// Reads the summary if it is complete: the definitions, the times of the chunks, the statistics.
  void read_summary() {
    constexpr std::uint64_t kFooter = kRecordHead + 20;
    if (size < kFooter + kMagic.size()) return;
    const std::uint64_t footer_at = size - kMagic.size() - kFooter;
    const std::string footer = file.bytes(footer_at, size);
    if (!std::string_view(footer).ends_with(kMagic) ||
        footer.front() != static_cast<char>(Opcode::footer))
      return;
    Cursor content(std::string_view(footer).substr(kRecordHead));
    const auto start = content.number<std::uint64_t>();
    content.number<std::uint64_t>();
    const auto crc = content.number<std::uint32_t>();
    if (start == 0 || start >= footer_at || footer_at - start > limits.record) return;
    const std::string summary = file.bytes(start, footer_at);
    constexpr std::size_t kNotInCrc = 4;
    if (crc != 0 &&
        crc != crc32(std::string_view(footer).substr(0, kFooter - kNotInCrc), crc32(summary)))
      return;
    for (Cursor rest(summary); !rest.empty();) {
      const auto opcode = static_cast<Opcode>(rest.number<std::uint8_t>());
      const std::string_view record = rest.bytes(rest.number<std::uint64_t>());
      if (!rest.ok()) return;
      Cursor fields(record);
      if (opcode == Opcode::schema || opcode == Opcode::channel) {
        definitions += record_of(opcode, record);
      } else if (opcode == Opcode::chunk_index) {
        const auto first = fields.number<std::uint64_t>(), last = fields.number<std::uint64_t>();
        times[fields.number<std::uint64_t>()] = {first, last};
      } else if (opcode == Opcode::statistics) {
        messages = fields.number<std::uint64_t>();
      }
    }
    summary_at = start;
  }

  /// Returns the error of the record, or nothing if a Reader accepts the record.
  std::optional<std::string> wrong_with(const std::string& record) {
    std::istringstream alone(definitions + record);
    try {
      Reader reader(alone, "file", limits);
      std::uint64_t here = 0;
      while (reader.next()) ++here;
      found += here;
      return std::nullopt;
    } catch (const FileError& error) {
      return reason_of(error);
    }
  }

  void miss(std::uint64_t begin, std::uint64_t end, std::string what, const std::string& record) {
    MissingPart part{.begin = begin, .end = end, .what = std::move(what)};
    if (const auto known = times.find(begin); known != times.end()) {
      part.times = known->second;
    } else if (!record.empty() && record.front() == static_cast<char>(Opcode::chunk)) {
      Cursor content(std::string_view(record).substr(kRecordHead));
      const auto first = content.number<std::uint64_t>(), last = content.number<std::uint64_t>();
      if (content.ok() && first <= last) part.times = {first, last};
    }
    // If the chunk's head is damaged, the summary may have the chunk's times.
    for (auto it = times.lower_bound(begin); it != times.end() && it->first < end; ++it) {
      const auto& [first, last] = it->second;
      part.times = part.times ? std::pair(std::min(part.times->first, first),
                                          std::max(part.times->second, last))
                              : std::pair(first, last);
    }
    missing.push_back(std::move(part));
  }

  void run(Parts& parts) {
    read_summary();
    std::uint64_t at = kMagic.size();
    if (file.bytes(0, at) != kMagic) miss(0, at, "the first bytes are none of an MCAP file", {});
    const std::uint64_t data_end = summary_at.value_or(size);
    while (at < data_end) {
      const auto head = file.head_at(at);
      if (!head || !is_possible(at, *head)) {
        const std::uint64_t next = std::min(file.next_after(at + 1), data_end);
        miss(at, next,
             next == size && !summary_at ? "the file ends within a record, or is damaged to its end"
                                         : "no record begins here",
             {});
        at = next;
        continue;
      }
      if (head->opcode == Opcode::data_end) {
        check_crc(at);
        at = head->end;
        ended = true;
        break;
      }
      at = take(parts, at, *head);
    }
    if (!summary_at && !ended && (missing.empty() || missing.back().end < size))
      miss(size, size, "the file ends before its footer: its last seconds may be missing", {});
    if (summary_at && !ended && missing.empty())
      miss(at, at, "the record that ends the data is damaged, but every chunk is whole", {});
    if (!summary_at && ended) miss(at, size, "the summary is damaged; no message is in it", {});
    for (const auto& entry : times) {
      const auto place = entry.first;
      const auto covers = [place](const MissingPart& m) {
        return m.begin <= place && place < m.end;
      };
      if (!whole_chunks.contains(place) && std::ranges::none_of(missing, covers))
        miss(place, place, "a chunk of the summary is not there", {});
    }
    parts.head = definitions;
  }

  /// Returns true if the data section may contain a record with this head. Refuses an index of the
  /// summary, because it may be a chunk with a damaged opcode.
  bool is_possible(std::uint64_t at, const RecordHead& head) const {
    constexpr std::uint64_t kDataEnd = kRecordHead + 4;
    if (head.end > summary_at.value_or(size)) return false;
    switch (head.opcode) {
      case Opcode::footer:
      case Opcode::chunk_index:
      case Opcode::attachment_index:
      case Opcode::metadata_index:
      case Opcode::statistics:
        return false;
      case Opcode::data_end:
        return head.end - at == kDataEnd && (!summary_at || head.end == *summary_at);
      case Opcode::chunk:
        return true;
      // A message outside chunks has no CRC. Accept it only if the summary lists no chunk.
      case Opcode::message:
        return summary_at && times.empty();
      default:
        return !times.contains(at);
    }
  }

  /// Checks the CRC of the data, because bytes outside all chunks may be damaged too.
  void check_crc(std::uint64_t data_end) {
    constexpr std::uint64_t kBlock = 1 << 20;
    const std::string record = file.bytes(data_end, data_end + kRecordHead + sizeof(std::uint32_t));
    const auto said = get<std::uint32_t>(std::string_view(record).substr(kRecordHead));
    if (said == 0 || !missing.empty()) return;
    std::uint32_t crc = 0;
    for (std::uint64_t at = 0; at < data_end; at += kBlock)
      crc = crc32(file.bytes(at, std::min(at + kBlock, data_end)), crc);
    if (crc != said)
      miss(data_end, data_end + record.size(),
           "the CRC of the data is wrong, but every chunk is whole", {});
  }

  /// Takes over a record if it is intact. Returns the position at which to continue.
  std::uint64_t take(Parts& parts, std::uint64_t at, const RecordHead& head) {
    const std::string record = file.bytes(at, head.end);
    if (!is_filled(head.opcode, std::string_view(record).substr(kRecordHead)))
      return lost(at, {}, "the length of a record is damaged");
    switch (head.opcode) {
      case Opcode::schema:
      case Opcode::channel:
        if (summary_at) return head.end;
        break;
      case Opcode::chunk:
      case Opcode::message:
      case Opcode::metadata:
      case Opcode::attachment:
        break;
      case Opcode::header:
      case Opcode::message_index:
        return head.end;
      default:  // The record is of a newer type.
        return file.is_record_at(at) ? head.end : lost(at, {}, "the length of a record is damaged");
    }
    const auto wrong = wrong_with(record);
    if (wrong) return lost(at, record, *wrong);
    if (head.opcode == Opcode::chunk) whole_chunks.insert(at);
    if (head.opcode == Opcode::schema || head.opcode == Opcode::channel)
      definitions += record;
    else if (!parts.ranges.empty() && parts.ranges.back().end == at)
      parts.ranges.back().end = head.end;
    else
      parts.ranges.push_back({at, head.end});
    return head.end;
  }

  /// Reports a damaged record. Returns the position at which to continue: the end of the record if
  /// its length is correct, or else the next record.
  std::uint64_t lost(std::uint64_t at, const std::string& record, const std::string& what) {
    const std::uint64_t behind = at + record.size();
    const std::uint64_t end = summary_at.value_or(size);
    const std::uint64_t next = !record.empty() && (behind == end || file.is_record_at(behind))
                                   ? behind
                                   : file.next_after(at + 1);
    miss(at, std::min(next, end), what, record);
    return std::min(next, end);
  }

  RecordSearch file;
  ReaderLimits limits;
  std::uint64_t size;
  std::string definitions;
  // Times of the first and last message of the chunks, by the chunk's position in the file.
  std::map<std::uint64_t, std::pair<std::uint64_t, std::uint64_t>> times;
  std::optional<std::uint64_t> summary_at, messages;
  std::uint64_t found = 0;  // number of intact messages
  std::set<std::uint64_t> whole_chunks;
  bool ended = false;
  std::vector<MissingPart> missing;
};

SalvagedFile::SalvagedFile(std::istream& in, const std::string& name, ReaderLimits limits)
    : parts_(std::make_unique<Parts>(in)) {
  Scan scan(in, limits);
  scan.run(*parts_);
  if (scan.found == 0 && !scan.missing.empty()) {
    in.clear();
    in.seekg(0);
    Reader reader(in, name, limits);  // The Reader throws the reason.
    while (reader.next()) continue;
  }
  missing_ = std::move(scan.missing);
  if (scan.messages) missing_messages_ = *scan.messages - std::min(*scan.messages, scan.found);
  stream_ = std::make_unique<std::istream>(parts_.get());
}

SalvagedFile::~SalvagedFile() = default;

std::istream& SalvagedFile::whole_parts() { return *stream_; }

std::string text(const MissingPart& part, std::optional<std::uint64_t> first) {
  std::string line =
      "byte " + std::to_string(part.begin) + " to " + std::to_string(part.end) + ": " + part.what;
  if (!part.times) return line;
  constexpr double kNanosecond = 1e-9;
  const auto since = [&](std::uint64_t time) {
    return kNanosecond * static_cast<double>(static_cast<std::int64_t>(time - first.value_or(0)));
  };
  std::array<char, 96> when{};
  if (first && part.times->second < *first)
    std::snprintf(when.data(), when.size(),
                  "; missing: %.3f s to %.3f s before the first message that is whole",
                  -since(part.times->first), -since(part.times->second));
  else
    std::snprintf(when.data(), when.size(), "; missing: %.3f s to %.3f s%s",
                  since(part.times->first), since(part.times->second),
                  first ? " of the recording" : "");
  return line + when.data();
}

}  // namespace feltwire::mcap
