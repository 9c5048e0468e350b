#include "core/recording/mcap_reader.hpp"

#include <algorithm>
#include <utility>

#include "core/base/file_error.hpp"
#include "core/base/foreign_content.hpp"

namespace feltwire::mcap {

Reader::Reader(std::istream& in, std::string name, ReaderLimits limits)
    : in_(in), name_(std::move(name)), limits_(limits) {
  const bool whole = fill(record_, kMagic.size());
  if (!kMagic.starts_with(record_)) {
    std::string begin = record_;
    constexpr std::size_t kLooked = 1024;
    fill(record_, kLooked);
    begin += record_;
    if (const auto foreign = foreign_content(begin))
      throw FileError(name_ + ": byte 0: " + *foreign);
    throw FileError(
        name_ +
        ": byte 0: this is no MCAP file; give one that --record wrote; if "
        "this is one with a damaged beginning, take what is whole in it with feltwire-lab export "
        "--skip-damaged");
  }
  ended_ = !whole;
  if (ended_) cut_at_ = 0;
}

void Reader::damaged(const std::string& what) const {
  throw FileError(
      name_ + ": byte " + std::to_string(record_at_) + ": " + what +
      "; the file is damaged: copy it anew from where it was recorded, or take what is whole in "
      "it with feltwire-lab export --skip-damaged");
}

/// Reads up to `size` bytes. Allocates memory only for bytes that exist. Returns false if there are
/// fewer bytes.
bool Reader::fill(std::string& to, std::uint64_t size) {
  constexpr std::uint64_t kStep = 1 << 20;
  to.clear();
  while (to.size() < size) {
    const std::size_t before = to.size();
    const auto step = static_cast<std::size_t>(std::min(size - before, kStep));
    to.resize(before + step);
    in_.read(to.data() + before, static_cast<std::streamsize>(step));
    to.resize(before + static_cast<std::size_t>(in_.gcount()));
    if (to.size() < before + step) break;
  }
  at_ += to.size();
  crc_ = crc32(to, crc_);
  return to.size() == size;
}

/// Returns the next record of the file, or nothing if no whole record is left.
std::optional<Reader::Record> Reader::read_record() {
  record_at_ = at_;
  crc_before_ = crc_;
  const auto cut = [this] {
    ended_ = true;
    cut_at_ = record_at_;
    return std::nullopt;
  };
  if (!fill(record_, kRecordHead)) return cut();
  Cursor head(record_);
  const auto opcode = head.number<std::uint8_t>();
  const auto length = head.number<std::uint64_t>();
  if (length > limits_.record)
    damaged("a record says that it has " + std::to_string(length) + " bytes, and at most " +
            std::to_string(limits_.record) + " are read");
  if (!fill(record_, length)) return cut();
  return Record{opcode, record_};
}

std::optional<Reader::Record> Reader::record_in_chunk() {
  if (chunk_.rest.empty()) return std::nullopt;
  Cursor rest(chunk_.rest);
  Record record;
  record.opcode = rest.number<std::uint8_t>();
  record.content = rest.bytes(rest.number<std::uint64_t>());
  require(rest.ok(), "a record of this chunk is longer than the chunk");
  chunk_.rest = rest.rest();
  return record;
}

std::optional<Message> Reader::next() {
  while (!ended_) {
    auto record = record_in_chunk();
    const bool in_chunk = record.has_value();
    if (!in_chunk) record = read_record();
    if (!record) break;
    if (in_chunk) {
      const auto opcode = static_cast<Opcode>(record->opcode);
      require(opcode != Opcode::chunk && opcode != Opcode::footer && opcode != Opcode::data_end,
              "a chunk has a record that may not be in one");
    }
    if (auto message = take(*record)) return message;
  }
  return std::nullopt;
}

std::optional<Message> Reader::take(const Record& record) {
  const Cursor content(record.content);
  switch (static_cast<Opcode>(record.opcode)) {
    case Opcode::schema:
      take_schema(content);
      break;
    case Opcode::channel:
      take_channel(content);
      break;
    case Opcode::message:
      return take_message(content);
    case Opcode::chunk:
      open_chunk(content);
      break;
    case Opcode::metadata:
      take_metadata(content);
      break;
    case Opcode::attachment:
      take_attachment(record.content);
      break;
    case Opcode::statistics:
      take_statistics(content);
      break;
    case Opcode::data_end:
      take_data_end(content);
      break;
    case Opcode::footer:
      take_footer(record.content);
      break;
    default:  // Indices and newer records are not needed.
      break;
  }
  return std::nullopt;
}

void Reader::take_schema(Cursor content) {
  const auto id = content.number<std::uint16_t>();
  Schema schema{std::string(content.text()), std::string(content.text()),
                std::string(content.text())};
  require(content.ok(), "a schema ends within a field");
  if (id == 0) return;  // By the specification, a schema with the number 0 is ignored.
  const auto known = schemas_.try_emplace(id, std::move(schema));
  require(known.second || known.first->second == schema, "two schemas have the same number");
}

void Reader::take_channel(Cursor content) {
  const auto id = content.number<std::uint16_t>();
  Channel channel;
  channel.schema = content.number<std::uint16_t>();
  channel.topic = content.text();
  channel.message_encoding = content.text();
  channel.metadata = map_of(content.text());
  require(content.ok(), "a channel ends within a field");
  require(channel.schema == 0 || schemas_.contains(channel.schema),
          "a channel has a schema that did not come before it");
  const auto known = channels_.try_emplace(id, std::move(channel));
  require(known.second || known.first->second == channel, "two channels have the same number");
}

Message Reader::take_message(Cursor content) {
  Message message;
  message.channel = content.number<std::uint16_t>();
  message.sequence = content.number<std::uint32_t>();
  message.log_time = content.number<std::uint64_t>();
  message.publish_time = content.number<std::uint64_t>();
  require(content.ok(), "a message ends within a field");
  require(channels_.contains(message.channel),
          "a message is of a channel that did not come before it");
  require(!data_ended_, "a message comes after the end of the data");
  message.data = content.rest();
  ++messages_;
  return message;
}

void Reader::take_metadata(Cursor content) {
  Metadata metadata;
  metadata.name = content.text();
  metadata.values = map_of(content.text());
  require(content.ok(), "a metadata record ends within a field");
  metadata_.push_back(std::move(metadata));
}

void Reader::take_attachment(std::string_view bytes) {
  Cursor content(bytes);
  Attachment attachment;
  attachment.log_time = content.number<std::uint64_t>();
  attachment.create_time = content.number<std::uint64_t>();
  attachment.name = content.text();
  attachment.media_type = content.text();
  attachment.data = content.bytes(content.number<std::uint64_t>());
  const std::size_t checked = bytes.size() - content.rest().size();
  const auto crc = content.number<std::uint32_t>();
  require(content.ok(), "an attachment ends within a field");
  require(crc == 0 || crc == crc32(bytes.substr(0, checked)), "the CRC of an attachment is wrong");
  attachments_.push_back(std::move(attachment));
}

void Reader::take_statistics(Cursor content) {
  Statistics s;
  s.messages = content.number<std::uint64_t>();
  s.schemas = content.number<std::uint16_t>();
  s.channels = content.number<std::uint32_t>();
  s.attachments = content.number<std::uint32_t>();
  s.metadata = content.number<std::uint32_t>();
  s.chunks = content.number<std::uint32_t>();
  s.start = content.number<std::uint64_t>();
  s.end = content.number<std::uint64_t>();
  Cursor counts(content.text());
  while (!counts.empty()) {
    const auto channel = counts.number<std::uint16_t>();
    s.channel_messages[channel] = counts.number<std::uint64_t>();
  }
  require(content.ok() && counts.ok(), "the statistics end within a field");
  statistics_ = std::move(s);
}

void Reader::open_chunk(Cursor content) {
  content.number<std::uint64_t>();  // Skip the times of the first and last message.
  content.number<std::uint64_t>();
  const auto size = content.number<std::uint64_t>();
  const auto crc = content.number<std::uint32_t>();
  const std::string_view compression = content.text();
  const std::string_view records = content.bytes(content.number<std::uint64_t>());
  require(content.ok(), "a chunk ends within a field");
  if (size > limits_.chunk)
    damaged("a chunk says that it has " + std::to_string(size) + " bytes, and at most " +
            std::to_string(limits_.chunk) + " are read");
  if (compression.empty()) {
    require(records.size() == size, "a chunk has another size than it says");
    chunk_.records = records;
  } else if (compression == "zstd") {
    require(decompressor_.decompress(records, static_cast<std::size_t>(size), chunk_.records),
            "a chunk cannot be decompressed");
  } else {
    throw FileError(name_ + ": byte " + std::to_string(record_at_) +
                    ": a chunk is compressed by a method that is not known here; convert the file "
                    "with: mcap compress --compression zstd");
  }
  require(crc == 0 || crc == crc32(chunk_.records), "the CRC of a chunk is wrong");
  chunk_.rest = chunk_.records;
  ++chunk_.count;
}

void Reader::take_data_end(Cursor content) {
  const auto crc = content.number<std::uint32_t>();
  require(content.ok(), "the end of the data ends within a field");
  require(crc == 0 || crc == crc_before_, "the CRC of the data is wrong");
  data_ended_ = true;
  crc_ = 0;  // The summary begins here.
}

void Reader::take_footer(std::string_view bytes) {
  Cursor content(bytes);
  constexpr std::size_t kStarts = 16;  // [bytes] size of the footer before its CRC
  content.bytes(kStarts);
  const auto crc = content.number<std::uint32_t>();
  require(content.ok() && content.empty(), "the footer has a wrong length");
  if (crc != 0) {
    require(data_ended_, "the summary does not come after the end of the data");
    std::string head;
    put(head, static_cast<std::uint8_t>(Opcode::footer));
    put(head, std::uint64_t{bytes.size()});
    require(crc == crc32(bytes.substr(0, kStarts), crc32(head, crc_before_)),
            "the CRC of the summary is wrong");
  }
  compare_statistics();
  ended_ = true;
  record_at_ = at_;
  std::string end;
  if (!fill(end, kMagic.size())) {
    require(kMagic.starts_with(end), "the file ends as no MCAP file does");
    cut_at_ = record_at_;
    return;
  }
  require(end == kMagic, "the file ends as no MCAP file does");
  record_at_ = at_;
  require(in_.peek() == std::istream::traits_type::eof(), "bytes follow the end");
}

std::map<std::string, std::string> Reader::map_of(std::string_view bytes) const {
  std::map<std::string, std::string> map;
  Cursor rest(bytes);
  while (!rest.empty()) {
    std::string key(rest.text());
    map[std::move(key)] = rest.text();
  }
  require(rest.ok(), "a map ends within an entry");
  return map;
}

void Reader::compare_statistics() const {
  if (!statistics_) return;
  require(statistics_->messages == messages_, "the statistics count other messages than there are");
  require(statistics_->chunks == chunk_.count, "the statistics count other chunks than there are");
}

}  // namespace feltwire::mcap
