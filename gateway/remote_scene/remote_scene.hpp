#pragma once
// A scene that another server computes. This process observes it, and shows the result to viewers.

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/servo/servo_loop.hpp"
#include "client/transport/backoff.hpp"
#include "client/transport/fleet_route.hpp"
#include "client/transport/listing.hpp"
#include "gateway/remote_scene/near_surfaces.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/scene_in_view.hpp"

namespace feltwire {

/// How an observer looks for its scene. The waits between attempts double, as those of a client
/// (RejoinOptions).
struct LookOptions {
  std::chrono::milliseconds first_wait{250}, longest_wait{4000};
  std::chrono::milliseconds timeout{1000};  // of each attempt, in each of its steps
  std::size_t list_room = kRoomOfServer;    // [bytes] for the list of the scene's sessions
};

class RemoteScene final : public SceneInView {
 public:
  /// `scene`: the shapes of the server's scene with that name, because no message contains shapes.
  RemoteScene(Scene scene, const ServerAccess& server, const LookOptions& options = {});
  /// stop().
  ~RemoteScene() override;
  RemoteScene(const RemoteScene&) = delete;
  RemoteScene& operator=(const RemoteScene&) = delete;

  /// Starts the thread that joins, observes, and joins again if the session was lost. Call it once.
  void start();
  /// Leaves the server. May be called again.
  void stop();
  /// The server has another scene with this name now. From any thread.
  void reload(Scene scene);

  const std::string& name() const override { return name_; }
  CurrentScene current_scene() const override;
  bool take_picture(Picture& picture) override;
  /// Gives what the server tells observers of its sessions. An older server tells only their
  /// numbers and tools.
  void describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) override;
  std::optional<std::string> out_of_sight() const override;
  /// The times that the server counted in this scene, as it told last. Empty: it did not tell them,
  /// or cannot be reached. From any thread.
  control::SceneTimes server_times() const;

 private:
  void run();
  std::string look_on();
  void ask_on(const Event& over);
  void ask_once(class ControlDialogue& server);
  void adopt(const control::SceneDescription& told, std::span<const Material> materials);
  void show(const class ObservedScene& seen);
  void hide(std::string why);

  const std::string name_;
  FleetRoute route_;  // of the thread; another one asks the host only while a session lasts
  const LookOptions options_;
  mutable std::mutex mutex_;  // guards the next members
  CurrentScene current_;
  Picture picture_;
  NearSurfaces near_;
  std::vector<HandDescription> hands_;
  control::SceneTimes server_times_;
  std::vector<control::SessionDescription> told_;  // hands of the server, by rising number
  Nanoseconds told_at_{0};
  /// The version of the server's scene, and the number of its live changes, that current_ has taken
  /// over. Empty: current_ is as the file says.
  std::optional<std::pair<std::uint32_t, std::uint32_t>> adopted_;
  bool fresh_ = false;  // no viewer has taken the picture
  std::optional<std::string> hidden_;
  Event stop_;
  bool joined_ = false;  // the attempt under way has got a session
  std::thread thread_;
};

}  // namespace feltwire
