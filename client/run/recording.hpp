#pragma once
// A recording of every tick, as a CSV file that stays readable however the run ends.

#include <cstdint>
#include <filesystem>

#include "client/servo/tick_record.hpp"
#include "core/base/line_file.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// Writes rows from a ring to a file: whole lines only, each batch in one write.
class RecordingFile {
 public:
  /// Creates or replaces the file and writes the header. Throws std::runtime_error naming the file
  /// and the reason.
  explicit RecordingFile(const std::filesystem::path& file);

  /// Writes all rows that wait. Throws std::runtime_error when the system takes no more (a full
  /// disk, say).
  void write(Ring<TickRecord>& rows);

  /// Waits until all that was written is on the disk. Throws std::runtime_error.
  void finish() { file_.finish(); }

  std::uint64_t rows() const { return rows_; }

 private:
  LineFile file_;
  std::uint64_t rows_ = 0;
};

}  // namespace feltwire
