#pragma once
// The records of an MCAP file that feltwire writes and reads (https://mcap.dev/spec). MCAP is a
// container: messages of several channels, each with its time, in chunks that are compressed.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace feltwire::mcap {

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

enum class Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0a,
  statistics = 0x0b,
  metadata = 0x0c,
  metadata_index = 0x0d,
  data_end = 0x0f
};

/// [bytes] before a record's content: its opcode and its length.
inline constexpr std::uint64_t kRecordHead = 9;

/// The description of the messages of a channel.
struct Schema {
  std::string name;      // "foxglove.SceneUpdate"
  std::string encoding;  // "protobuf"
  std::string data;      // of protobuf: a FileDescriptorSet
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::uint16_t schema = 0;
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata{};
  bool operator==(const Channel&) const = default;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0, publish_time = 0;  // [ns]
  std::string_view data;
};

/// A file inside the file.
struct Attachment {
  std::uint64_t log_time = 0, create_time = 0;  // [ns]
  std::string name, media_type, data;
  bool operator==(const Attachment&) const = default;
};

struct Metadata {
  std::string name;
  std::map<std::string, std::string> values;
  bool operator==(const Metadata&) const = default;
};

struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  std::uint64_t start = 0, end = 0;  // [ns] log time of the first and the last message
  std::map<std::uint16_t, std::uint64_t> channel_messages{};
};

}  // namespace feltwire::mcap
