#pragma once
// Reads an MCAP file of any writer from its beginning to its end.

#include <cstdint>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/recording/compression.hpp"
#include "core/recording/mcap_bytes.hpp"
#include "core/recording/mcap_records.hpp"

namespace feltwire::mcap {

/// The largest sizes that a file may have.
struct ReaderLimits {
  std::uint64_t record = std::uint64_t{256} << 20;  // [bytes] a record, and an attachment
  std::uint64_t chunk = std::uint64_t{64} << 20;    // [bytes] a chunk, decompressed
};

/// Every length is checked before it is used, and every CRC in the file is compared. An error is
/// thrown as FileError "NAME: byte N: what; remedy". A file that ends before its footer is not an
/// error: it is read up to its last whole record, and cut_at() gives that place.
class Reader {
 public:
  /// `in` must outlive this. Throws FileError if its beginning is not that of an MCAP file.
  Reader(std::istream& in, std::string name, ReaderLimits limits = {});

  /// The next message, in the file's order; empty at the end. Its data are valid until the next
  /// call, and its channel is one of channels(). Throws FileError.
  std::optional<Message> next();

  /// After the end: the byte at which the file was cut; empty: it is whole.
  std::optional<std::uint64_t> cut_at() const { return cut_at_; }

  // The records that were read so far.
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  const std::vector<Metadata>& metadata() const { return metadata_; }
  const std::vector<Attachment>& attachments() const { return attachments_; }
  /// The file's own statistics, which agree with the messages that were read. They are there only
  /// for a whole file, after its end.
  const std::optional<Statistics>& statistics() const { return statistics_; }

 private:
  struct Record {
    std::uint8_t opcode = 0;
    std::string_view content;
  };

  /// The open chunk.
  struct Chunk {
    std::string records;      // decompressed
    std::string_view rest;    // not read yet
    std::uint32_t count = 0;  // of chunks so far, with this one
  };

  [[noreturn]] void damaged(const std::string& what) const;
  void require(bool good, const char* what) const {
    if (!good) damaged(what);
  }
  bool fill(std::string& to, std::uint64_t size);
  std::optional<Record> read_record();
  std::optional<Record> record_in_chunk();
  std::optional<Message> take(const Record& record);
  void take_schema(Cursor content);
  void take_channel(Cursor content);
  Message take_message(Cursor content);
  void take_metadata(Cursor content);
  void take_attachment(std::string_view bytes);
  void take_statistics(Cursor content);
  void open_chunk(Cursor content);
  void take_data_end(Cursor content);
  void take_footer(std::string_view bytes);
  std::map<std::string, std::string> map_of(std::string_view bytes) const;
  void compare_statistics() const;

  std::istream& in_;
  std::string name_;
  ReaderLimits limits_;
  Decompressor decompressor_;
  std::uint64_t at_ = 0;                    // [bytes] read so far
  std::uint64_t record_at_ = 0;             // the beginning of the newest record
  std::uint32_t crc_ = 0, crc_before_ = 0;  // of the section, up to now and up to the newest record
  bool data_ended_ = false, ended_ = false;  // DataEnd came; there is no more
  std::string record_;
  Chunk chunk_;
  std::optional<std::uint64_t> cut_at_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<Metadata> metadata_;
  std::vector<Attachment> attachments_;
  std::optional<Statistics> statistics_;
  std::uint64_t messages_ = 0;
};

}  // namespace feltwire::mcap
