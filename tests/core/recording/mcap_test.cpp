#include <gmock/gmock.h>
#include <zstd.h>

#include "core/base/file_error.hpp"
#include "tests/core/recording/recordings.hpp"

namespace feltwire::mcap_test {
namespace {

using test::keep_recording;
using test::read_mcap;
using test::ReadFile;
using test::ReadMessage;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::uint64_t kMillisecond = 1'000'000;

mcap::Attachment scene_attachment() {
  return {.log_time = 1,
          .create_time = 2,
          .name = "scene.json",
          .media_type = "application/json",
          .data = "{}"};
}

/// Two channels, six messages in three chunks, metadata and an attachment.
struct SmallFile {
  std::string bytes;
  std::vector<std::size_t> chunk_ends;
};
SmallFile small_file(bool zstd) {
  SmallFile file;
  mcap::Writer writer({.library = "test", .zstd = zstd});
  const auto schema = writer.add(mcap::Schema{"a.B", "protobuf", "descriptor"});
  const auto one = writer.add(mcap::Channel{schema, "/one", "protobuf", {{"unit", "m"}}});
  const auto two = writer.add(mcap::Channel{0, "/two", "json"});
  writer.add(mcap::Metadata{"run", {{"scene", "plane"}, {"part", "1"}}});
  for (std::uint64_t i = 0; i < 3; ++i) {
    writer.write(one, i * kMillisecond, "first " + std::to_string(i));
    writer.write(two, i * kMillisecond, "{}");
    writer.end_chunk();
    file.bytes += writer.take();
    file.chunk_ends.push_back(file.bytes.size());
  }
  writer.attach(scene_attachment());
  writer.finish();
  file.bytes += writer.take();
  return file;
}

std::string error_of(const std::string& bytes, mcap::ReaderLimits limits = {}) {
  try {
    read_mcap(bytes, limits);
  } catch (const FileError& error) {
    return error.what();
  }
  return {};
}

/// Returns a file with a correct beginning and then these records.
std::string begun(const std::string& records) {
  mcap::Writer writer({.library = "test"});
  const auto schema = writer.add(mcap::Schema{"a.B", "protobuf", ""});
  writer.add(mcap::Channel{schema, "/one", "protobuf"});
  return writer.take() + records;
}

std::string record(mcap::Opcode opcode, const std::string& content) {
  std::string out;
  mcap::put(out, static_cast<std::uint8_t>(opcode));
  mcap::put(out, std::uint64_t{content.size()});
  return out + content;
}

std::string chunk(std::uint64_t size, const std::string& compression, const std::string& records,
                  std::uint32_t crc = 0) {
  std::string content;
  mcap::put(content, std::uint64_t{0});
  mcap::put(content, std::uint64_t{0});
  mcap::put(content, size);
  mcap::put(content, crc);
  mcap::put_text(content, compression);
  mcap::put(content, std::uint64_t{records.size()});
  return record(mcap::Opcode::chunk, content + records);
}

TEST(Mcap, GivesBackWhatWasWritten) {
  for (const bool zstd : {false, true}) {
    const SmallFile small = small_file(zstd);
    keep_recording(zstd ? "small_zstd.mcap" : "small_plain.mcap", small.bytes);
    const ReadFile file = read_mcap(small.bytes);
    EXPECT_FALSE(file.cut_at);
    ASSERT_EQ(file.messages.size(), 6u);
    EXPECT_EQ(file.messages[4], (ReadMessage{"/one", "first 2", 2, 2 * kMillisecond}));
    EXPECT_EQ(file.messages[5], (ReadMessage{"/two", "{}", 2, 2 * kMillisecond}));
    ASSERT_EQ(file.metadata.size(), 1u);
    EXPECT_EQ(file.metadata[0], (mcap::Metadata{"run", {{"scene", "plane"}, {"part", "1"}}}));
    ASSERT_EQ(file.attachments.size(), 1u);
    EXPECT_EQ(file.attachments[0], scene_attachment());
    EXPECT_EQ(file.schemas.at(1), (mcap::Schema{"a.B", "protobuf", "descriptor"}));
    EXPECT_EQ(file.channels.at(1).metadata.at("unit"), "m");
    ASSERT_TRUE(file.statistics);
    EXPECT_EQ(file.statistics->messages, 6u);
    EXPECT_EQ(file.statistics->chunks, 3u);
    EXPECT_EQ(file.statistics->start, 0u);
    EXPECT_EQ(file.statistics->end, 2 * kMillisecond);
    EXPECT_EQ(file.statistics->channel_messages.at(2), 3u);
  }
}

TEST(Mcap, AFileWithoutMessagesIsWhole) {
  mcap::Writer writer;
  writer.finish();
  const std::string bytes = writer.take();
  keep_recording("empty.mcap", bytes);
  const ReadFile file = read_mcap(bytes);
  EXPECT_TRUE(file.messages.empty());
  EXPECT_FALSE(file.cut_at);
}

TEST(Mcap, AFileCutAtAnyByteGivesTheChunksThatAreWhole) {
  for (const bool zstd : {false, true}) {
    const SmallFile small = small_file(zstd);
    const auto all = read_mcap(small.bytes).messages;
    for (std::size_t size = 0; size < small.bytes.size(); ++size) {
      const ReadFile file = read_mcap(small.bytes.substr(0, size));
      ASSERT_TRUE(file.cut_at) << size;
      ASSERT_LE(*file.cut_at, size);
      std::size_t chunks = 0;
      while (chunks < small.chunk_ends.size() && small.chunk_ends[chunks] <= size) ++chunks;
      // The indexes after a chunk are optional.
      ASSERT_GE(file.messages.size(), 2 * chunks) << size;
      ASSERT_LE(file.messages.size(), 2 * chunks + 2) << size;
      for (std::size_t i = 0; i < file.messages.size(); ++i) ASSERT_EQ(file.messages[i], all[i]);
    }
  }
}

TEST(Mcap, NoDamagedByteGoesUnseen) {
  const std::string bytes = small_file(true).bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int bit : {0, 4, 7}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      bool seen = false;
      try {
        seen = read_mcap(damaged).cut_at.has_value();  // The length extends beyond the end.
      } catch (const FileError&) {
        seen = true;
      }
      ASSERT_TRUE(seen) << "byte " << i << " bit " << bit;
    }
  }
}

TEST(Mcap, ADamagedChunkIsNamedWithItsPlace) {
  SmallFile small = small_file(false);
  const std::size_t at = small.bytes.find("first 1");
  ASSERT_NE(at, std::string::npos);
  small.bytes[at] = 'F';
  const std::string error = error_of(small.bytes);
  EXPECT_THAT(error, StartsWith("file.mcap: byte "));
  EXPECT_THAT(error, HasSubstr("the CRC of a chunk is wrong; the file is damaged: copy it anew"));
}

TEST(Mcap, OtherFilesAreRefused) {
  EXPECT_THAT(error_of("t,x,y,z\n0,0,0,0\n"), HasSubstr("file.mcap: byte 0: this is no MCAP file"));
  EXPECT_THAT(error_of("\x89PNG"), HasSubstr("this is no MCAP file"));
}

TEST(Mcap, LengthsAreNotBelieved) {
  std::string huge;
  mcap::put(huge, static_cast<std::uint8_t>(mcap::Opcode::metadata));
  mcap::put(huge, ~std::uint64_t{0});
  EXPECT_THAT(error_of(begun(huge)),
              HasSubstr("18446744073709551615 bytes, and at most 268435456"));

  const std::string message = record(mcap::Opcode::message, "short");
  EXPECT_THAT(error_of(begun(message)), HasSubstr("a message ends within a field"));
  EXPECT_THAT(error_of(begun(chunk(9, "", "123456789"))), HasSubstr("longer than the chunk"));
  EXPECT_THAT(error_of(begun(chunk(10, "", "123456789"))), HasSubstr("another size than it says"));
  EXPECT_THAT(error_of(begun(chunk(9, "zstd", "123456789"))), HasSubstr("cannot be decompressed"));
  EXPECT_THAT(error_of(begun(chunk(9, "lz4", "123456789"))), HasSubstr("--compression zstd"));
  EXPECT_THAT(error_of(begun(chunk(9, "", record(mcap::Opcode::footer, "")))),
              HasSubstr("record that may not be in one"));
}

/// A chunk of zeros would decompress to a large size.
TEST(Mcap, AChunkMayNotBeLargerThanTheLimitSays) {
  const std::string zeros(1 << 20, '\0');
  std::string small(ZSTD_compressBound(zeros.size()), '\0');
  small.resize(ZSTD_compress(small.data(), small.size(), zeros.data(), zeros.size(), 1));
  const mcap::ReaderLimits limits{.chunk = 1 << 16};
  EXPECT_THAT(error_of(begun(chunk(zeros.size(), "zstd", small)), limits),
              HasSubstr("a chunk says that it has 1048576 bytes, and at most 65536 are read"));
  // The chunk states a false size.
  EXPECT_THAT(error_of(begun(chunk(100, "zstd", small)), limits),
              HasSubstr("cannot be decompressed"));
}

TEST(Mcap, AMessageNeedsItsChannel) {
  std::string content;
  mcap::put(content, std::uint16_t{7});
  content.append(20, '\0');
  EXPECT_THAT(error_of(begun(record(mcap::Opcode::message, content))),
              HasSubstr("of a channel that did not come before it"));
}

TEST(Mcap, AMessageOutsideOfChunksIsRead) {
  std::string content;
  mcap::put(content, std::uint16_t{1});
  content.append(20, '\0');
  const ReadFile file = read_mcap(begun(record(mcap::Opcode::message, content + "data")));
  ASSERT_EQ(file.messages.size(), 1u);
  EXPECT_EQ(file.messages[0].data, "data");
}

TEST(Mcap, RecordsOfANewerVersionArePassedOver) {
  std::string unknown;
  mcap::put(unknown, std::uint8_t{0x7f});
  mcap::put(unknown, std::uint64_t{3});
  EXPECT_TRUE(read_mcap(begun(unknown + "abc")).cut_at);
}

TEST(Mcap, AChunkEndsWithItsTimeAndItsSize) {
  mcap::Writer writer({.chunk_bytes = 1000, .chunk_time = 10 * kMillisecond});
  const auto channel = writer.add(mcap::Channel{0, "/one", "json"});
  for (std::uint64_t i = 0; i <= 10; ++i) writer.write(channel, i * kMillisecond, "x");
  const std::uint64_t open = writer.size();
  writer.write(channel, 11 * kMillisecond, "x");
  const std::uint64_t ended = writer.size();
  EXPECT_GT(ended, open);
  writer.write(channel, 11 * kMillisecond, std::string(900, 'x'));
  EXPECT_EQ(writer.size(), ended);
  writer.write(channel, 11 * kMillisecond, std::string(900, 'x'));
  EXPECT_GT(writer.size(), ended);
  writer.finish();
  const std::string bytes = writer.take();
  keep_recording("chunks.mcap", bytes);
  EXPECT_EQ(read_mcap(bytes).statistics->chunks, 3u);
  EXPECT_EQ(writer.size(), bytes.size());
}

}  // namespace
}  // namespace feltwire::mcap_test
