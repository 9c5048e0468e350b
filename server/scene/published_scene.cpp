#include "server/scene/published_scene.hpp"

#include <exception>
#include <utility>

namespace feltwire {
namespace {

void draw_wanted(PictureExchange& pictures, const SceneSessions& sessions,
                 Nanoseconds now) noexcept {
  if (!pictures.wanted()) return;
  try {
    Picture& picture = pictures.picture();
    picture.version = sessions.scene_version();
    sessions.draw(picture, now);
    pictures.give();
  } catch (const std::exception&) {
    // There is no memory for the picture. The next call tries again.
  }
}

}  // namespace

SceneInView::CurrentScene PublishedScene::current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

void PublishedScene::set(std::shared_ptr<const Scene> scene,
                         const SceneSessions& sessions) noexcept {
  const auto objects = static_cast<std::uint32_t>(scene->objects().size());
  {
    const std::lock_guard lock(mutex_);
    current_ = {std::move(scene), sessions.scene_version(), sessions.live_changes(),
                sessions.gravity()};
  }
  objects_.store(objects, std::memory_order_relaxed);
}

void PublishedScene::draw(const SceneSessions& sessions, Nanoseconds now) noexcept {
  draw_wanted(pictures_, sessions, now);
  if (recorded_) draw_wanted(recorded_pictures_, sessions, now);
}

}  // namespace feltwire
