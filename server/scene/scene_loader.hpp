#pragma once
// Loads scenes anew beside a server that runs: each in a thread of its own, so that a slow file or
// a dead disk delays nothing else.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire {

/// A scene, or what is wrong with its file.
using LoadedScene = std::variant<Scene, std::string>;

/// A scene from its file, with a line in the log for each thing in it that is strange. Throws
/// FileError.
Scene load_scene_and_warn(const std::filesystem::path& file);
/// The same, and keeps the files in the scene for a recording.
Scene load_scene_keep_and_warn(const std::filesystem::path& file);

class SceneLoader {
 public:
  using Load = std::function<Scene(const std::filesystem::path& file)>;
  /// Called in the thread that loaded.
  using Done = std::function<void(LoadedScene loaded)>;

  /// `scenes`: how many there are. `load` may be called by several threads at once.
  explicit SceneLoader(std::size_t scenes, Load load = load_scene_and_warn);
  /// Stops.
  ~SceneLoader();
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  /// Begins to load a scene; false where it is being loaded already. Throws std::system_error where
  /// there is no thread for it. One thread at a time calls this, tell() and stop().
  bool begin(std::size_t scene, const std::filesystem::path& file, Done done);

  /// A line in the log on each load that goes on for 5 s, 10 s, 20 s and so on.
  void tell();

  /// Cancels what is loaded and waits for at most `patience`. A thread that does not end by then
  /// (a read from a dead disk cannot be interrupted) is left behind and makes no more calls;
  /// false where there is one. May be called again.
  bool stop(std::chrono::milliseconds patience = std::chrono::seconds(1));

 private:
  struct Job;
  Load load_;
  std::vector<std::shared_ptr<Job>> jobs_;  // by scene; null: none has been loaded yet
};

}  // namespace feltwire
