// Recovers the intact parts of damaged recordings.
#include "core/recording/mcap_salvage.hpp"

#include <gmock/gmock.h>

#include <random>
#include <set>

#include "core/base/file_error.hpp"
#include "tests/core/recording/recordings.hpp"

namespace feltwire::mcap_salvage_test {
namespace {

using test::ReadMessage;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::size_t kChunks = 8, kInChunk = 20;

struct File {
  std::string bytes;
  std::vector<std::size_t> begins, ends;  // positions of the chunk records
  std::size_t data_end = 0;               // end of the last chunk's indexes
};

File file_of(bool zstd) {
  File file;
  mcap::Writer writer({.library = "test", .zstd = zstd});
  const auto schema = writer.add(mcap::Schema{"a.B", "protobuf", "descriptor"});
  const auto one = writer.add(mcap::Channel{schema, "/one", "protobuf"});
  const auto two = writer.add(mcap::Channel{0, "/two", "json"});
  writer.add(mcap::Metadata{"run", {{"scene", "plane"}}});
  file.bytes += writer.take();
  for (std::size_t c = 0; c < kChunks; ++c) {
    file.begins.push_back(file.bytes.size());
    for (std::size_t i = 0; i < kInChunk; ++i) {
      const std::uint64_t n = c * kInChunk + i;
      writer.write(n % 2 == 0 ? one : two, n * kMillisecond, "message " + std::to_string(n * n));
    }
    writer.end_chunk();
    file.bytes += writer.take();
    // The chunk's head has its length, without the indexes.
    std::uint64_t length = 0;
    for (std::size_t i = 8; i > 0; --i)
      length = length << 8 | static_cast<std::uint8_t>(file.bytes[file.begins.back() + i]);
    file.ends.push_back(file.begins.back() + 9 + length);
  }
  file.data_end = file.bytes.size();
  writer.finish();
  file.bytes += writer.take();
  return file;
}

struct Salvaged {
  std::vector<ReadMessage> messages;
  std::vector<mcap::MissingPart> missing;
  std::optional<std::uint64_t> missing_messages;
};
Salvaged salvage(const std::string& bytes) {
  std::istringstream in(bytes);
  mcap::SalvagedFile file(in, "file.mcap");
  mcap::Reader reader(file.whole_parts(), "file.mcap");
  Salvaged found;
  while (const auto message = reader.next())
    found.messages.push_back({reader.channels().at(message->channel).topic,
                              std::string(message->data), message->sequence, message->log_time});
  found.missing = file.missing();
  found.missing_messages = file.missing_messages();
  return found;
}

/// Returns all messages except those of the given chunks.
std::vector<ReadMessage> without(const std::vector<ReadMessage>& all,
                                 std::set<std::size_t> chunks) {
  std::vector<ReadMessage> left;
  for (std::size_t n = 0; n < all.size(); ++n)
    if (!chunks.contains(n / kInChunk)) left.push_back(all[n]);
  return left;
}

TEST(McapSalvage, AWholeFileIsWhole) {
  for (const bool zstd : {false, true}) {
    const File file = file_of(zstd);
    const Salvaged found = salvage(file.bytes);
    EXPECT_EQ(found.messages, test::read_mcap(file.bytes).messages);
    EXPECT_THAT(found.missing, IsEmpty());
    EXPECT_EQ(found.missing_messages, 0u);
  }
}

/// For any bad byte, the search must find all undamaged chunks and report the damage.
TEST(McapSalvage, OneBadByteAnywhereTakesNoOtherChunk) {
  for (const bool zstd : {false, true}) {
    const File file = file_of(zstd);
    const auto all = test::read_mcap(file.bytes).messages;
    // The test changes every byte of two chunks, of the part before them and of the end, and some
    // other bytes.
    const auto step = [&](std::size_t at) {
      return at > file.ends[1] + 300 && at < file.data_end ? std::size_t{11} : std::size_t{1};
    };
    for (std::size_t at = 0; at < file.bytes.size(); at += step(at))
      for (const int bits : {0x01, 0x80, 0xFF}) {
        std::string bytes = file.bytes;
        bytes[at] = static_cast<char>(bytes[at] ^ bits);
        const Salvaged found = salvage(bytes);
        std::set<std::size_t> lost;
        for (std::size_t c = 0; c < kChunks; ++c)
          if (at >= file.begins[c] && at < file.ends[c]) lost.insert(c);
        // No CRC covers the times in a chunk's head. A chunk with wrong times is still intact.
        const auto& expected = found.messages.size() == all.size() ? all : without(all, lost);
        ASSERT_EQ(found.messages, expected) << at << " of " << file.bytes.size() << " ^ " << bits;
        ASSERT_FALSE(found.missing.empty()) << at << " ^ " << bits;
      }
  }
}

TEST(McapSalvage, WhatIsMissingIsSaidWithItsTimes) {
  const File file = file_of(true);
  std::string bytes = file.bytes;
  bytes[(file.begins[3] + file.ends[3]) / 2] ^= 0x10;
  const Salvaged found = salvage(bytes);
  ASSERT_THAT(found.missing, SizeIs(1));
  EXPECT_EQ(found.missing[0].begin, file.begins[3]);
  EXPECT_EQ(found.missing[0].end, file.ends[3]);
  EXPECT_EQ(found.missing[0].times, std::pair(60 * kMillisecond, 79 * kMillisecond));
  EXPECT_EQ(found.missing_messages, kInChunk);
  EXPECT_THAT(mcap::text(found.missing[0], 0),
              AllOf(HasSubstr("byte " + std::to_string(file.begins[3]) + " to "),
                    HasSubstr("missing: 0.060 s to 0.079 s of the recording")));
  // If the beginning is missing, the first whole message gives the origin.
  EXPECT_THAT(mcap::text(found.missing[0], 100 * kMillisecond),
              HasSubstr("missing: 0.040 s to 0.021 s before the first message that is whole"));
}

TEST(McapSalvage, ATruncatedFileGivesItsWholeChunks) {
  for (const bool zstd : {false, true}) {
    const File file = file_of(zstd);
    const auto all = test::read_mcap(file.bytes).messages;
    for (std::size_t end = file.ends[0]; end < file.data_end; end += 7) {
      const Salvaged found = salvage(file.bytes.substr(0, end));
      std::size_t whole = 0;
      while (whole < kChunks && file.ends[whole] <= end) ++whole;
      ASSERT_EQ(found.messages.size(), whole * kInChunk) << end;
      ASSERT_FALSE(found.missing.empty()) << end;
    }
    // The file is truncated and has a bad chunk before the cut.
    std::string bytes = file.bytes.substr(0, file.ends[5] + 20);
    bytes[file.ends[2] - 3] ^= 0x40;
    EXPECT_EQ(salvage(bytes).messages,
              without(std::vector(all.begin(), all.begin() + 6 * kInChunk), {2}));
  }
}

TEST(McapSalvage, SeveralDamagedPartsAreEachMissed) {
  const File file = file_of(true);
  const auto all = test::read_mcap(file.bytes).messages;
  std::mt19937 random(2);
  for (int n = 0; n < 100; ++n) {
    std::string bytes = file.bytes;
    std::set<std::size_t> lost;
    for (int bad = 0; bad < 3; ++bad) {
      const std::size_t c = random() % kChunks;
      // The bad byte is after the head of a chunk, or in a length, which then has any value.
      const std::size_t at =
          bad == 0 ? file.begins[c] + 1 + random() % 4
                   : file.begins[c] + 60 + random() % (file.ends[c] - file.begins[c] - 60);
      bytes[at] = static_cast<char>(bytes[at] + 1 + static_cast<int>(random() % 200));
      lost.insert(c);
    }
    ASSERT_EQ(salvage(bytes).messages, without(all, lost)) << n;
  }
}

TEST(McapSalvage, WhatIsNoRecordingIsRefused) {
  for (const std::string& bytes :
       {std::string("version https://git-lfs.github.com/spec/v1\noid sha256:1\n"),
        std::string(1000, 'x'), std::string("PK\x03\x04")}) {
    try {
      salvage(bytes);
      ADD_FAILURE() << bytes.substr(0, 10);
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), ::testing::StartsWith("file.mcap: byte 0: "));
    }
  }
}

}  // namespace
}  // namespace feltwire::mcap_salvage_test
