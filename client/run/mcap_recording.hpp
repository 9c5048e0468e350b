#pragma once
// A recording of every tick as MCAP files (docs/recording.md).

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client/run/recording.hpp"
#include "core/base/appended_file.hpp"
#include "core/recording/mcap_writer.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// Each tick as feltwire.Sample and feltwire.Account, and 60 times a second a picture of the hand
/// and its force, or of an observer's view. Written data wait in memory for about a second, until
/// their chunk is full.
class McapRecording final : public Recorder {
 public:
  /// Creates or replaces the first file. Throws std::runtime_error that names the file and the
  /// reason.
  explicit McapRecording(RecordingTarget target, std::int64_t offset = clock_offset());

  void write(Ring<TickRecord>& rows) override;
  void see(double time, const ObservedScene& scene) override;
  /// A metadata record, `change`. Its `time` [ns since 1970] is this moment, unless it is given.
  void note(const std::map<std::string, std::string>& values) override;
  /// A metadata record, `mark`, with `text` and `time` [ns since 1970].
  void mark(const std::string& text) override;
  void finish() override;

 private:
  struct Part {
    Part(const RecordingTarget& target, int number);
    void flush() { file.append(writer.take()); }
    AppendedFile file;
    mcap::Writer writer;
    std::uint16_t sample = 0, account = 0, pose = 0, picture = 0, scene = 0;  // channels
  };

  void add_metadata(const std::string& name, std::map<std::string, std::string> values);
  bool part_is_over(std::uint64_t time) const;
  void add(const TickRecord& row, std::uint64_t time);
  void add_picture(const TickRecord& row, std::uint64_t time);

  RecordingTarget target_;
  std::int64_t offset_;
  int number_ = 1;
  std::unique_ptr<Part> part_;
  std::uint64_t part_start_ = 0;               // [ns]
  std::optional<std::uint64_t> first_tick_{};  // [ns]
  PictureRate pictures_, views_;
  std::string message_;
};

}  // namespace feltwire
