#pragma once
// Records the scenes of a server in a thread of its own.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/recording/asked_recording.hpp"
#include "server/recording/flight_recorder.hpp"
#include "server/recording/scene_recording.hpp"

namespace feltwire {

struct RecorderOptions {
  std::filesystem::path file = {};  // for the only scene; empty: none is written
  RecordingLimits limits{};
  std::filesystem::path flight_folder = {};  // for flight records; empty: none is written
  AskedRecordingOptions asked = {};          // recordings that admins start
  /// Describes a scene for the page's replay. It may take some 10 ms. Empty: files have no such
  /// description.
  std::function<SceneToShow(const Scene& scene)> describe = {};
  bool any() const { return !file.empty() || !flight_folder.empty() || !asked.folder.empty(); }
};

/// Returns a scene's name for a file name: other characters than letters, digits, '-' and '_'
/// become '_', and `place` then separates two names.
std::string name_in_files(const std::string& scene, std::size_t place);
/// FILE.mcap of a server with one scene, FILE-SCENE.mcap of one with several.
std::filesystem::path recording_file(const std::filesystem::path& file,
                                     const std::vector<std::string>& scenes, std::size_t place);

/// Takes the events in the logs of the scenes' threads, and pictures, and writes both to files. If
/// a file cannot be written any more, the log names it once; the server continues.
class Recorder {
 public:
  /// Creates the files. Throws std::runtime_error that names the file and the reason.
  Recorder(const RecorderOptions& options, const std::vector<Scene>& scenes);
  /// Stops the recorder.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The event log of the scene at this index. It lives as long as the recorder.
  EventLog& log(std::size_t scene) { return scenes_[scene]->log; }
  /// Gives the source of the scene's pictures, and the scene as it is when an admin starts a
  /// recording (null: such files do not describe it). Both must outlive the recorder's thread. Call
  /// it before start().
  void see(std::size_t scene, PictureExchange& pictures, const SceneInView* present = nullptr) {
    scenes_[scene]->pictures = &pictures;
    scenes_[scene]->present = present;
  }

  void start();
  /// Writes the rest and joins the thread. Call it after the scenes' threads have ended. May be
  /// called again.
  void stop();

  /// Requests a flight record of each scene. From any thread.
  void ask_for_flight_records();
  /// Called on the recorder's thread with the name of a flight record; empty: it could not be
  /// written, and the log says why. It must not throw.
  using FlightWritten = std::function<void(std::optional<std::filesystem::path> file)>;
  /// Requests a flight record of one scene, and its name. From any thread. Precondition: there is a
  /// folder for them.
  void ask_for_flight_record(std::size_t scene, FlightWritten written);

  /// Called on the recorder's thread with the recordings of a scene, or with the reason of a
  /// refusal. It must not throw.
  using Recorded =
      std::function<void(std::variant<control::SceneRecordings, control::Refused> outcome)>;
  /// Starts or stops a recording of one scene, or only looks. From any thread. Precondition: there
  /// is a folder for them.
  void record(std::size_t scene, control::RecordingAction action, Recorded done);

 private:
  struct OneScene {
    OneScene(std::string scene, std::shared_ptr<const CapturedFiles> kept);
    std::string name;
    std::shared_ptr<const CapturedFiles> files;  // of the first version of the scene
    EventLog log;
    PictureExchange* pictures = nullptr;
    const SceneInView* present = nullptr;
    Picture picture;
    std::unique_ptr<SceneRecording> recording;  // null: none, or it failed
    std::unique_ptr<FlightRecorder> flight;     // null: none
    std::uint64_t told_lost = 0;
    std::unique_ptr<AskedRecording> asked;                               // null: admins start none
    std::vector<FlightWritten> wanted;                                   // guarded
    std::vector<std::pair<control::RecordingAction, Recorded>> actions;  // guarded
  };

  void run();
  void look();
  void look(OneScene& scene);
  void look_after_flights(OneScene& scene);
  void look_after_asked(OneScene& scene);
  template <class Action>
  void write(OneScene& scene, Action action);

  std::vector<std::unique_ptr<OneScene>> scenes_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;  // guarded
  std::thread thread_;
};

}  // namespace feltwire
