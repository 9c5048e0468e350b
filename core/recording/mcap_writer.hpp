#pragma once
// Writes an MCAP file as bytes; the owner of the file stores them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/recording/compression.hpp"
#include "core/recording/mcap_records.hpp"

namespace feltwire::mcap {

struct WriterOptions {
  std::string library = "feltwire";  // the writer of the file
  bool zstd = true;                  // false: the chunks are not compressed
  // A chunk ends before it has more, or spans more time: the largest loss of a cut file.
  std::size_t chunk_bytes = std::size_t{1} << 18;
  std::uint64_t chunk_time = 1'000'000'000;  // [ns] of log time
};

/// The order: add() the schemas and channels, then write(), then finish(). attach() and add() of
/// metadata may come at any time before finish(). After each call take() gives whole records.
///
/// A cut file is readable up to its last whole record. Messages are in the file when their chunk
/// is, which is about a second later.
class Writer {
 public:
  explicit Writer(WriterOptions options = {});

  /// The id for a channel.
  std::uint16_t add(const Schema& schema);
  /// The id for write().
  std::uint16_t add(const Channel& channel);
  void add(const Metadata& metadata);
  void attach(const Attachment& attachment);

  /// `time` [ns] is the log time and the publish time. `channel` was given by add(), and the data
  /// has less than 4 GiB.
  void write(std::uint16_t channel, std::uint64_t time, std::string_view data);
  /// Ends the chunk: take() then returns all messages so far.
  void end_chunk();
  /// Writes the index and the end of the file. After it only take() may be called.
  void finish();

  /// The bytes since the last call, in whole records.
  std::string take() { return std::exchange(out_, {}); }
  /// [bytes] of the file so far, without the open chunk.
  std::uint64_t size() const { return size_; }
  std::uint64_t messages() const { return statistics_.messages; }

 private:
  struct ChannelState {
    Channel channel;
    std::uint32_t sequence = 0;
    std::string index{};  // (time, offset) of its messages in the open chunk
  };

  std::uint64_t put_record(Opcode opcode, std::string_view content);
  void put_summary();

  WriterOptions options_;
  Compressor compressor_;
  std::string out_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes so far, or of the summary
  std::vector<Schema> schemas_;
  std::vector<ChannelState> channels_;
  std::string chunk_, content_;
  std::uint64_t chunk_start_ = 0, chunk_end_ = 0;  // [ns]
  std::vector<std::string> chunk_indexes_, attachment_indexes_, metadata_indexes_;
  Statistics statistics_;
};

}  // namespace feltwire::mcap
