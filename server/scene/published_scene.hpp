#pragma once
// The state of a scene for other threads.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

#include "server/picture/picture.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

/// Owns what the scene's thread publishes: the present scene, its size, and pictures of it.
class PublishedScene {
 public:
  /// `recorded`: a recorder takes pictures too.
  explicit PublishedScene(bool recorded) : recorded_(recorded) {}

  // From any thread.
  SceneInView::CurrentScene current() const;
  std::uint32_t objects() const { return objects_.load(std::memory_order_relaxed); }
  std::uint32_t sessions() const { return sessions_.load(std::memory_order_relaxed); }
  /// Pictures for viewers, and for a recorder's thread: one thread takes from each.
  PictureExchange& pictures() { return pictures_; }
  PictureExchange& recorded_pictures() { return recorded_pictures_; }

  // From the scene's thread.
  /// The scene, or a property of it, has changed.
  void set(std::shared_ptr<const Scene> scene, const SceneSessions& sessions) noexcept;
  void set_sessions(std::size_t count) noexcept {
    sessions_.store(static_cast<std::uint32_t>(count), std::memory_order_relaxed);
  }
  /// Draws the pictures that somebody waits for. Without memory there is none.
  void draw(const SceneSessions& sessions, Nanoseconds now) noexcept;

 private:
  mutable std::mutex mutex_;           // guards the next member, which the scene's thread writes
  SceneInView::CurrentScene current_;  // changes only at a reload or a live change
  std::atomic<std::uint32_t> objects_{0}, sessions_{0};
  PictureExchange pictures_, recorded_pictures_;
  bool recorded_;
};

}  // namespace feltwire
