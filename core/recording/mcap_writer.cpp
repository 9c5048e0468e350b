#include "core/recording/mcap_writer.hpp"

#include <algorithm>

#include "core/recording/mcap_bytes.hpp"

namespace feltwire::mcap {
namespace {

std::string map_bytes(const std::map<std::string, std::string>& map) {
  std::string out;
  for (const auto& [key, value] : map) {
    put_text(out, key);
    put_text(out, value);
  }
  return out;
}

std::string content_of(std::uint16_t id, const Schema& schema) {
  std::string out;
  put(out, id);
  put_text(out, schema.name);
  put_text(out, schema.encoding);
  put_text(out, schema.data);
  return out;
}

std::string content_of(std::uint16_t id, const Channel& channel) {
  std::string out;
  put(out, id);
  put(out, channel.schema);
  put_text(out, channel.topic);
  put_text(out, channel.message_encoding);
  put_text(out, map_bytes(channel.metadata));
  return out;
}

std::string content_of(const Statistics& statistics) {
  std::string out, counts;
  for (const auto& [channel, count] : statistics.channel_messages) {
    put(counts, channel);
    put(counts, count);
  }
  put(out, statistics.messages);
  put(out, statistics.schemas);
  put(out, statistics.channels);
  put(out, statistics.attachments);
  put(out, statistics.metadata);
  put(out, statistics.chunks);
  put(out, statistics.start);
  put(out, statistics.end);
  put_text(out, counts);
  return out;
}

void put_head(std::string& out, Opcode opcode, std::uint64_t length) {
  put(out, static_cast<std::uint8_t>(opcode));
  put(out, length);
}

}  // namespace

Writer::Writer(WriterOptions options) : options_(std::move(options)) {
  out_ = kMagic;
  size_ = out_.size();
  crc_ = crc32(out_);
  std::string content;
  put_text(content, "");  // no message profile
  put_text(content, options_.library);
  put_record(Opcode::header, content);
}

/// Writes a record. Returns its position in the file.
std::uint64_t Writer::put_record(Opcode opcode, std::string_view content) {
  const std::uint64_t start = size_;
  const std::size_t before = out_.size();
  put_head(out_, opcode, content.size());
  out_ += content;
  const std::string_view record = std::string_view(out_).substr(before);
  crc_ = crc32(record, crc_);
  size_ += record.size();
  return start;
}

std::uint16_t Writer::add(const Schema& schema) {
  schemas_.push_back(schema);
  const auto id = static_cast<std::uint16_t>(schemas_.size());  // 0 means: no schema
  put_record(Opcode::schema, content_of(id, schema));
  return id;
}

std::uint16_t Writer::add(const Channel& channel) {
  channels_.push_back({.channel = channel});
  const auto id = static_cast<std::uint16_t>(channels_.size());
  put_record(Opcode::channel, content_of(id, channel));
  return id;
}

void Writer::add(const Metadata& metadata) {
  std::string content, index;
  put_text(content, metadata.name);
  put_text(content, map_bytes(metadata.values));
  put(index, put_record(Opcode::metadata, content));
  put(index, kRecordHead + content.size());
  put_text(index, metadata.name);
  metadata_indexes_.push_back(std::move(index));
}

void Writer::attach(const Attachment& attachment) {
  std::string content, index;
  put(content, attachment.log_time);
  put(content, attachment.create_time);
  put_text(content, attachment.name);
  put_text(content, attachment.media_type);
  put(content, std::uint64_t{attachment.data.size()});
  content += attachment.data;
  put(content, crc32(content));
  put(index, put_record(Opcode::attachment, content));
  put(index, kRecordHead + content.size());
  put(index, attachment.log_time);
  put(index, attachment.create_time);
  put(index, std::uint64_t{attachment.data.size()});
  put_text(index, attachment.name);
  put_text(index, attachment.media_type);
  attachment_indexes_.push_back(std::move(index));
}

void Writer::write(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  constexpr std::size_t kBeforeData = 22;  // [bytes] size of a message before its data
  const std::size_t size = kRecordHead + kBeforeData + data.size();
  const bool too_long =
      std::max(time, chunk_end_) - std::min(time, chunk_start_) > options_.chunk_time;
  if (!chunk_.empty() && (chunk_.size() + size > options_.chunk_bytes || too_long)) end_chunk();
  chunk_start_ = chunk_.empty() ? time : std::min(chunk_start_, time);
  chunk_end_ = chunk_.empty() ? time : std::max(chunk_end_, time);

  ChannelState& state = channels_[channel - 1u];
  put(state.index, time);
  put(state.index, std::uint64_t{chunk_.size()});
  put_head(chunk_, Opcode::message, kBeforeData + data.size());
  put(chunk_, channel);
  put(chunk_, state.sequence++);
  put(chunk_, time);
  put(chunk_, time);
  chunk_ += data;

  Statistics& s = statistics_;
  s.start = s.messages == 0 ? time : std::min(s.start, time);
  s.end = std::max(s.end, time);
  ++s.messages;
  ++s.channel_messages[channel];
}

void Writer::end_chunk() {
  if (chunk_.empty()) return;
  const std::string_view compression = options_.zstd ? "zstd" : "";
  content_.clear();
  put(content_, chunk_start_);
  put(content_, chunk_end_);
  put(content_, std::uint64_t{chunk_.size()});
  put(content_, crc32(chunk_));
  put_text(content_, compression);
  const std::size_t length_at = content_.size();
  put(content_, std::uint64_t{0});
  const std::size_t records_at = content_.size();
  if (options_.zstd)
    compressor_.compress(chunk_, content_);
  else
    content_ += chunk_;
  const std::uint64_t compressed = content_.size() - records_at;
  put_little_endian(reinterpret_cast<std::uint8_t*>(&content_[length_at]), compressed);
  const std::uint64_t chunk_at = put_record(Opcode::chunk, content_);
  const std::uint64_t indexes_at = size_;

  std::string places, index;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].index.empty()) continue;
    const auto id = static_cast<std::uint16_t>(i + 1);
    index.clear();
    put(index, id);
    put_text(index, channels_[i].index);
    channels_[i].index.clear();
    put(places, id);
    put(places, put_record(Opcode::message_index, index));
  }
  index.clear();
  put(index, chunk_start_);
  put(index, chunk_end_);
  put(index, chunk_at);
  put(index, indexes_at - chunk_at);
  put_text(index, places);
  put(index, size_ - indexes_at);
  put_text(index, compression);
  put(index, compressed);
  put(index, std::uint64_t{chunk_.size()});
  chunk_indexes_.push_back(index);
  chunk_.clear();
}

void Writer::put_summary() {
  for (std::size_t i = 0; i < schemas_.size(); ++i)
    put_record(Opcode::schema, content_of(static_cast<std::uint16_t>(i + 1), schemas_[i]));
  for (std::size_t i = 0; i < channels_.size(); ++i)
    put_record(Opcode::channel,
               content_of(static_cast<std::uint16_t>(i + 1), channels_[i].channel));
  for (const std::string& index : chunk_indexes_) put_record(Opcode::chunk_index, index);
  for (const std::string& index : attachment_indexes_) put_record(Opcode::attachment_index, index);
  for (const std::string& index : metadata_indexes_) put_record(Opcode::metadata_index, index);
  statistics_.schemas = static_cast<std::uint16_t>(schemas_.size());
  statistics_.channels = static_cast<std::uint32_t>(channels_.size());
  statistics_.attachments = static_cast<std::uint32_t>(attachment_indexes_.size());
  statistics_.metadata = static_cast<std::uint32_t>(metadata_indexes_.size());
  statistics_.chunks = static_cast<std::uint32_t>(chunk_indexes_.size());
  put_record(Opcode::statistics, content_of(statistics_));
}

void Writer::finish() {
  end_chunk();
  std::string content;
  put(content, crc_);
  put_record(Opcode::data_end, content);

  crc_ = 0;
  const std::uint64_t summary_start = size_;
  put_summary();
  // The CRC covers the summary, and the footer up to the CRC itself.
  constexpr std::uint64_t kFooter = 20;
  const std::size_t before = out_.size();
  put_head(out_, Opcode::footer, kFooter);
  put(out_, summary_start);
  put(out_, std::uint64_t{0});  // The file has no summary offsets.
  put(out_, crc32(std::string_view(out_).substr(before), crc_));
  out_ += kMagic;
  size_ += out_.size() - before;
}

}  // namespace feltwire::mcap
