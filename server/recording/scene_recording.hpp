#pragma once
// The MCAP files of one scene: the inputs that decide its replies, and pictures of it
// (docs/recording.md).

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "core/base/appended_file.hpp"
#include "core/base/captured_files.hpp"
#include "core/recording/mcap_writer.hpp"
#include "core/recording/recording_files.hpp"
#include "server/picture/picture.hpp"
#include "server/scene/event_log.hpp"

namespace feltwire {

/// A scene as the live page shows it, so that a replay on the page draws it.
struct SceneToShow {
  std::string message{};   // the page's message `scene`, JSON; empty: the file has none
  std::string geometry{};  // a foxglove.SceneUpdate with the triangles of its objects
};

/// The file of a scene's recording, and its metadata of the server.
struct SceneRecordingTarget {
  std::filesystem::path file;
  RecordingLimits limits{};
  std::map<std::string, std::string> about{};
  std::string option = "--record";  // that named the file
  SceneToShow shown{};              // a reload ends it: files that begin later have none
};

/// Returns the metadata: the server, the version and the build that computed the recording.
std::map<std::string, std::string> about_recording(const std::string& scene);
/// Appends an event as a feltwire.Event.
void append_event(std::string& out, const SceneEvent& event);

/// Puts the scene's files into an MCAP file, so that replay() can load the scene again: `number` is
/// 0 for the first scene, else that of the reload.
void attach_scene(mcap::Writer& writer, const CapturedFiles& files, std::uint64_t number,
                  std::uint64_t time);

/// Messages wait in memory for about a second, until their chunk is full.
class SceneRecording {
 public:
  /// Creates or replaces the first file. `files`: of the scene; null: they were not kept, and no
  /// replay can load it. Throws std::runtime_error that names the file and the reason, as the other
  /// functions do.
  SceneRecording(SceneRecordingTarget target, const CapturedFiles* files, std::int64_t offset);

  /// `files`: the files of a reload.
  void add(const SceneEvent& event, const CapturedFiles* files = nullptr);
  void see(const Picture& picture);
  void flush() { part_->flush(); }
  /// [bytes] of the present file so far.
  std::uint64_t bytes() const { return part_->file.size(); }
  /// Waits until all is on the disk.
  void finish();

 private:
  struct Part {
    Part(const SceneRecordingTarget& target, int number);
    void flush() { file.append(writer.take()); }
    AppendedFile file;
    mcap::Writer writer;
    std::uint16_t events = 0, pictures = 0, geometry = 0;  // channels
    std::uint64_t begun = 0;  // [bytes] of the file with the scene, which counts for no limit
  };
  mcap::Writer& part_for(std::uint64_t time);
  void begin_part(std::uint64_t time);

  SceneRecordingTarget target_;
  std::int64_t offset_;
  int number_ = 1;
  std::unique_ptr<Part> part_;
  std::uint64_t part_start_ = 0;  // [ns]
  PictureRate rate_;
  std::set<std::string> shown_, gone_;  // entities of the last picture
  std::string message_;
};

}  // namespace feltwire
