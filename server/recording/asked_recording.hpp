#pragma once
// Recordings of a scene that an admin starts and stops while the server runs (docs/recording.md).

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "core/recording/recording_files.hpp"
#include "protocol/wire/control.hpp"
#include "server/recording/scene_recording.hpp"

namespace feltwire {

/// Returns the free room [bytes] on the disk of a folder; empty: it is not known.
std::optional<std::uintmax_t> free_room(const std::filesystem::path& folder);

/// The folder of such recordings, and their limits.
struct AskedRecordingOptions {
  static constexpr double kMebibytes = 1024.0, kSeconds = 3600.0;  // unless the options say others
  static constexpr std::size_t kMostFiles = 20;                    // of a scene
  static constexpr std::uintmax_t kMostBytes = std::uintmax_t{8} << 30;  // before a new one

  std::filesystem::path folder = {};  // empty: admins start no recordings
  RecordingLimits limits{kMebibytes, kSeconds};
  std::uintmax_t least_room = std::uintmax_t{1} << 30;  // [bytes] that stay free on the disk
  std::function<std::optional<std::uintmax_t>(const std::filesystem::path& folder)> room =
      free_room;
  std::function<SceneToShow()> shown = {};  // the present scene; empty: files have none to show
};

/// The recordings of one scene: one runs at most. All calls are on the recorder's thread.
class AskedRecording {
 public:
  /// Creates the folder if it is missing. Throws FileError that names it and the reason.
  /// `offset`: clock_offset().
  AskedRecording(AskedRecordingOptions options, const std::string& scene, std::string name,
                 std::int64_t offset);

  /// Starts or stops a recording, or only looks. Returns the state after it, or why it is refused.
  std::variant<control::SceneRecordings, control::Refused> act(control::RecordingAction action,
                                                               Nanoseconds now);
  void add(const SceneEvent& event);
  void see(const Picture& picture);
  /// Writes what waits, and ends a recording that has reached a limit.
  void look_after(Nanoseconds now);
  /// Ends a recording that runs.
  void finish();

 private:
  std::optional<control::Refused> start(Nanoseconds now);
  void end(control::RecordingEnd why);
  template <class Action>
  void write(Action action);
  bool has_room() const;
  control::SceneRecordings state(Nanoseconds now) const;

  AskedRecordingOptions options_;
  std::string scene_, name_;  // the scene's; the same in names of files
  std::int64_t offset_;
  std::unique_ptr<SceneRecording> recording_;  // null: none runs
  std::filesystem::path file_;                 // of that one
  Nanoseconds started_{0}, looked_at_room_{0};
  double seconds_ = 0.0;     // [s] that the last one took
  std::uint64_t bytes_ = 0;  // of the last one
  control::RecordingEnd ended_ = control::RecordingEnd::none;
};

/// Returns the reason for people, as "its largest size is reached". Empty for none and asked.
const char* text(control::RecordingEnd why);

}  // namespace feltwire
