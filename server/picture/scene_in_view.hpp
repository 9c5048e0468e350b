#pragma once
// A scene that viewers see. This process computes it, or a server that this process observes.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/session/live_change.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/picture.hpp"

namespace feltwire {

/// Runs a function later in the thread of whoever asks. The scene's threads call it, so it has to
/// work until they have ended. Throws std::bad_alloc.
using PostBack = std::function<void(std::function<void()>)>;

/// The changes that an admin may make in a scene. Call them from any thread.
class SceneControls {
 public:
  virtual ~SceneControls() = default;
  /// Makes a live change, and posts the result back: the change, or the reason of the refusal.
  virtual void change(LiveChange change, PostBack back,
                      std::function<void(std::variant<std::string, control::Refused>)> done) = 0;
  /// Ends a session with a goodbye, if it is there.
  virtual void evict(std::uint64_t session) = 0;
};

class SceneInView {
 public:
  virtual ~SceneInView() = default;
  virtual const std::string& name() const = 0;

  /// The present scene, from any thread. Its version is 1, and one more with each reload.
  struct CurrentScene {
    std::shared_ptr<const Scene> scene;
    std::uint32_t version = 0;
    std::uint32_t changes = 0;    // live ones of materials and gravity
    std::optional<Vec3> gravity;  // [m/s^2]; empty: nothing moves
  };
  virtual CurrentScene current_scene() const = 0;

  /// Copies the newest picture and requests the next (PictureExchange::take), for one viewers'
  /// thread. False: there is no new one, and `picture` is unchanged.
  virtual bool take_picture(Picture& picture) = 0;
  /// Posts descriptions of the hands back. From any thread.
  virtual void describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) = 0;

  /// The reason why the scene cannot be seen now, for people; empty: it can be seen. From any
  /// thread.
  virtual std::optional<std::string> out_of_sight() const { return std::nullopt; }
  /// Null: the scene can only be observed here.
  virtual SceneControls* controls() { return nullptr; }
};

}  // namespace feltwire
