#pragma once
// The search for records in an MCAP file that may be damaged.

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

#include "core/recording/mcap_bytes.hpp"
#include "core/recording/mcap_reader.hpp"

namespace feltwire::mcap {

struct RecordHead {
  Opcode opcode;
  std::uint64_t end;  // byte position of the record's end
};

/// Whether the fields of a record's content fill it. A record that is too long would hide the
/// records after it. True for records of a type whose fields are not known.
bool is_filled(Opcode opcode, std::string_view content);

/// Finds records by their positions. Takes nothing for granted of what stands between them.
class RecordSearch {
 public:
  /// `file` must outlive this, be seekable, and not be used elsewhere meanwhile.
  RecordSearch(std::istream& file, ReaderLimits limits);

  std::uint64_t size() const noexcept { return size_; }  // [bytes] of the file

  /// Returns the bytes from `begin` to `end`, or fewer if the file ends before.
  std::string bytes(std::uint64_t begin, std::uint64_t end);

  /// Returns the head of a record, or nothing if its length is impossible.
  std::optional<RecordHead> head_at(std::uint64_t at);

  /// Returns true if a record begins at `at`. Either its fields fill it, or another record follows.
  /// The other record may be incomplete.
  bool is_record_at(std::uint64_t at);

  /// Returns the position of the next record, at `at` or later, that cannot be in a chunk; the size
  /// of the file if there is none.
  std::uint64_t next_after(std::uint64_t at);

 private:
  std::istream& file_;
  ReaderLimits limits_;
  std::uint64_t size_;
};

}  // namespace feltwire::mcap
