#pragma once
// The whole parts of a damaged MCAP file.

#include <cstdint>
#include <iosfwd>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/recording/mcap_reader.hpp"

namespace feltwire::mcap {

/// A part of a file that cannot be read.
struct MissingPart {
  std::uint64_t begin = 0, end = 0;  // [bytes]
  std::string what;                  // "the CRC of a chunk is wrong"
  /// [ns] log time of the first and the last message in it, if the file still says so.
  std::optional<std::pair<std::uint64_t, std::uint64_t>> times = {};
};

/// The whole parts of a file, as a file that a Reader reads, and a list of the others. A record is
/// whole if its lengths fit, its CRC is right and the reader accepts it. After a damaged one the
/// search goes on behind it; if its length is damaged too, at the next record that others follow.
/// Schemas and channels come from the summary if that is whole.
class SalvagedFile {
 public:
  /// Reads the file once. `in` must outlive this, be seekable, and not be used elsewhere meanwhile.
  /// Throws FileError as a Reader does if no whole chunk is in it.
  SalvagedFile(std::istream& in, const std::string& name, ReaderLimits limits = {});
  ~SalvagedFile();
  SalvagedFile(const SalvagedFile&) = delete;
  SalvagedFile& operator=(const SalvagedFile&) = delete;

  /// The whole parts. A Reader finds this file cut at its end if it has no footer.
  std::istream& whole_parts();
  /// In the order of the file. Empty: the file is whole.
  const std::vector<MissingPart>& missing() const { return missing_; }
  /// Messages that the file's statistics count, and that are not in the whole parts; empty: the
  /// statistics are not readable.
  std::optional<std::uint64_t> missing_messages() const { return missing_messages_; }

 private:
  class Parts;
  struct Scan;

  std::unique_ptr<Parts> parts_;
  std::unique_ptr<std::istream> stream_;
  std::vector<MissingPart> missing_;
  std::optional<std::uint64_t> missing_messages_;
};

/// A line about a missing part: its bytes, what is wrong, and the time. `first` [ns]: log time of
/// the recording's first whole message, from which times are counted, forwards or backwards.
std::string text(const MissingPart& part, std::optional<std::uint64_t> first);

}  // namespace feltwire::mcap
