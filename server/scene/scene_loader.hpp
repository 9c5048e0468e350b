#pragma once
// Loads scenes again while a server runs, each in a thread of its own, so that a slow file or a
// dead disk delays no other scene.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire {

/// A scene, or the error in its file.
using LoadedScene = std::variant<Scene, std::string>;

/// Loads a scene from its file and logs its warnings. Throws FileError.
Scene load_scene_and_warn(const std::filesystem::path& file);
/// Loads it in the same way, and keeps the files in the scene for a recording.
Scene load_scene_keep_and_warn(const std::filesystem::path& file);

class SceneLoader {
 public:
  using Load = std::function<Scene(const std::filesystem::path& file)>;
  /// Called in the loading thread.
  using Done = std::function<void(LoadedScene loaded)>;

  /// `scenes`: their number. Several threads may call `load` at once.
  explicit SceneLoader(std::size_t scenes, Load load = load_scene_and_warn);
  /// Stops all loads.
  ~SceneLoader();
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  /// Begins to load a scene; false if it is being loaded already. Throws std::system_error if there
  /// is no thread for it. Only one thread at a time may call this, tell() and stop().
  bool begin(std::size_t scene, const std::filesystem::path& file, Done done);

  /// Logs a line about each load that has lasted 5 s, 10 s, 20 s and so on.
  void tell();

  /// Cancels the loads and waits for at most `patience`. A thread that does not end by then (a read
  /// from a dead disk cannot be interrupted) is left behind and makes no more calls; then the
  /// result is false. May be called again.
  bool stop(std::chrono::milliseconds patience = std::chrono::seconds(1));

 private:
  struct Job;
  Load load_;
  std::vector<std::shared_ptr<Job>> jobs_;  // by scene; null: nothing was loaded yet
};

}  // namespace feltwire
