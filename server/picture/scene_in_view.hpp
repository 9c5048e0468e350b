#pragma once
// A scene that viewers are shown, whoever computes it: this process, or a server that this process
// looks on at.

#include <asio/io_context.hpp>
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

/// The changes that an admin may make in a scene. Call them from any thread.
class SceneControls {
 public:
  virtual ~SceneControls() = default;
  /// Makes a live change, and posts what it came to to `back`: what was changed, or why it was
  /// refused. `back` outlives the scene's threads.
  virtual void change(LiveChange change, asio::io_context& back,
                      std::function<void(std::variant<std::string, control::Refused>)> done) = 0;
  /// Ends a session with a goodbye, if it is there.
  virtual void evict(std::uint64_t session) = 0;
};

class SceneInView {
 public:
  virtual ~SceneInView() = default;
  virtual const std::string& name() const = 0;

  /// The scene as it is now, from any thread. Its version is 1, and one more with each reload.
  struct CurrentScene {
    std::shared_ptr<const Scene> scene;
    std::uint32_t version = 0;
    std::uint32_t changes = 0;    // live ones of materials and gravity
    std::optional<Vec3> gravity;  // [m/s^2]; nothing: nothing moves
  };
  virtual CurrentScene current_scene() const = 0;

  /// Copies the newest picture and asks for the next (PictureExchange::take), for one viewers'
  /// thread. False: none is new, and `picture` is as it was.
  virtual bool take_picture(Picture& picture) = 0;
  /// Posts what is known of the hands to `back`, which outlives the scene's threads. From any
  /// thread.
  virtual void describe(asio::io_context& back,
                        std::function<void(std::vector<HandDescription>)> done) = 0;

  /// Why the scene cannot be seen at the moment, for people; nothing: it is seen. From any thread.
  virtual std::optional<std::string> out_of_sight() const { return std::nullopt; }
  /// Null: the scene can only be looked at here.
  virtual SceneControls* controls() { return nullptr; }
};

}  // namespace feltwire
