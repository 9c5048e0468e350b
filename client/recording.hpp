#pragma once
// What happened at each tick, as a CSV file that stays readable however the run ends.

#include <cstdint>
#include <filesystem>

#include "client/line_file.hpp"
#include "client/ring.hpp"
#include "core/types.hpp"

namespace feltwire {

/// One row: t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age.
struct TickRecord {
  double time = 0.0;               // t [s] since the first tick
  Vec3 position = Vec3::Zero();    // x,y,z [m]
  Vec3 elastic = Vec3::Zero();     // ex.. [N] of the newest command of the environment, on the hand
  Vec3 frictional = Vec3::Zero();  // fx.. [N] likewise
  Vec3 held = Vec3::Zero();        // rx.. [N] what the hand was given from here on
  double age = -1.0;               // [s] of the command; -1 before the first
};

/// Writes rows from a ring to a file: whole lines only, each batch in one write.
class RecordingFile {
 public:
  /// Creates or replaces the file and writes the header. Throws std::runtime_error naming the file
  /// and the reason.
  explicit RecordingFile(const std::filesystem::path& file);

  /// Writes all rows that wait. Throws std::runtime_error when the system takes no more (a full
  /// disk, say).
  void write(Ring<TickRecord>& rows);

  /// Has all that was written be on the disk. Throws likewise.
  void finish() { file_.finish(); }

  std::uint64_t rows() const { return rows_; }

 private:
  LineFile file_;
  std::uint64_t rows_ = 0;
};

}  // namespace feltwire
