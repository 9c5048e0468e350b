#pragma once
// Shared by the tests of recordings: whole files in memory, and files that are kept for another
// reader (tests/recording).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/recording/mcap_reader.hpp"
#include "core/recording/mcap_writer.hpp"

namespace feltwire::test {

struct ReadMessage {
  std::string topic, data;
  std::uint32_t sequence = 0;
  std::uint64_t time = 0;
  bool operator==(const ReadMessage&) const = default;
};

struct ReadFile {
  std::vector<ReadMessage> messages;
  std::optional<std::uint64_t> cut_at;
  std::vector<mcap::Metadata> metadata;
  std::vector<mcap::Attachment> attachments;
  std::map<std::uint16_t, mcap::Schema> schemas;
  std::map<std::uint16_t, mcap::Channel> channels;
  std::optional<mcap::Statistics> statistics;
};

/// Throws FileError.
inline ReadFile read_mcap(const std::string& bytes, mcap::ReaderLimits limits = {}) {
  std::istringstream in(bytes);
  mcap::Reader reader(in, "file.mcap", limits);
  ReadFile file;
  while (const auto message = reader.next())
    file.messages.push_back({reader.channels().at(message->channel).topic,
                             std::string(message->data), message->sequence, message->log_time});
  file.cut_at = reader.cut_at();
  file.metadata = reader.metadata();
  file.attachments = reader.attachments();
  file.schemas = reader.schemas();
  file.channels = reader.channels();
  file.statistics = reader.statistics();
  return file;
}

/// Keeps the file in the folder that FELTWIRE_KEEP_RECORDINGS names, if it does.
inline void keep_recording(const std::string& name, const std::string& bytes) {
  if (const char* folder = std::getenv("FELTWIRE_KEEP_RECORDINGS"))
    std::ofstream(std::filesystem::path(folder) / name, std::ios::binary) << bytes;
}

/// Keeps a folder's newest file there too, as PROGRAM-TEST.mcap of the running test.
inline void keep_recordings(const std::string& program, const std::filesystem::path& folder) {
  const char* keep = std::getenv("FELTWIRE_KEEP_RECORDINGS");
  if (keep == nullptr) return;
  std::filesystem::path newest;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".mcap") newest = std::max(newest, entry.path());
  if (newest.empty()) return;
  std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::ranges::replace(name, '/', '_');
  std::filesystem::copy_file(newest, std::filesystem::path(keep) / (program + '-' + name + ".mcap"),
                             std::filesystem::copy_options::overwrite_existing);
}

}  // namespace feltwire::test
