#pragma once
// A recording of every tick, in a file that stays readable after every end of the run.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "client/run/observed_scene.hpp"
#include "client/servo/tick_record.hpp"
#include "core/base/line_file.hpp"
#include "core/base/ring.hpp"
#include "core/recording/recording_files.hpp"

namespace feltwire {

/// The place of a recording, and the metadata of an MCAP file.
struct RecordingTarget {
  std::filesystem::path file;
  RecordingLimits limits{};
  std::map<std::string, std::string> about{};
  std::string option = "--record";  // that named the file, for errors
};

inline std::filesystem::path numbered(const RecordingTarget& target, int number) {
  return numbered(target.file, target.limits, number);
}

/// Writes rows from a ring to a file.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Writes all waiting rows. Throws std::runtime_error if the system takes no more (for example on
  /// a full disk).
  virtual void write(Ring<TickRecord>& rows) = 0;
  /// Writes an observer's view at `time` [s] since the first tick. A format without pictures writes
  /// nothing.
  virtual void see(double /*time*/, const ObservedScene& /*scene*/) {}
  /// Writes an event of this moment. A format without events writes nothing.
  virtual void note(const std::map<std::string, std::string>& /*values*/) {}
  /// Writes a text of the user at this moment. A format without events writes nothing.
  virtual void mark(const std::string& /*text*/) {}
  /// Waits until all data are on the disk. Throws std::runtime_error.
  virtual void finish() = 0;
};

/// A CsvRecording or an McapRecording, by the name of the file.
std::unique_ptr<Recorder> open_recording(const RecordingTarget& target);

/// Whole lines only, each batch in one write.
class CsvRecording final : public Recorder {
 public:
  /// Creates or replaces the file and writes the header. Throws std::runtime_error that names the
  /// file and the reason.
  explicit CsvRecording(const std::filesystem::path& file);

  void write(Ring<TickRecord>& rows) override;
  void finish() override { file_.finish(); }

  std::uint64_t rows() const { return rows_; }

 private:
  LineFile file_;
  std::uint64_t rows_ = 0;
};

}  // namespace feltwire
