// The state of a scene for other threads, without a thread.

#include "server/scene/published_scene.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::published_scene_test {
namespace {

using namespace std::chrono_literals;

struct Published {
  explicit Published(bool recorded = false) : published(recorded) {
    published.set(scene, sessions);
  }
  std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(test::room());
  SceneSessions sessions{*scene, 2s, 4};
  PublishedScene published;
};

TEST(PublishedScene, HasThePresentSceneAndItsSize) {
  Published p;
  EXPECT_EQ(p.published.current().scene, p.scene);
  EXPECT_EQ(p.published.current().version, 1u);
  EXPECT_FALSE(p.published.current().gravity);
  EXPECT_EQ(p.published.objects(), 2u);
  EXPECT_EQ(p.published.sessions(), 0u);
  p.published.set_sessions(3);
  EXPECT_EQ(p.published.sessions(), 3u);
}

TEST(PublishedScene, AReloadIsANewVersion) {
  Published p;
  const auto next =
      std::make_shared<const Scene>("room", std::vector<Object>{p.scene->objects().front()});
  p.sessions.enter(*next, 1s);
  p.published.set(next, p.sessions);
  EXPECT_EQ(p.published.current().scene, next);
  EXPECT_EQ(p.published.current().version, 2u);
  EXPECT_EQ(p.published.objects(), 1u);
}

TEST(PublishedScene, DrawsAPictureOnlyIfSomebodyWaits) {
  Published p;
  p.sessions.answer(test::join_request(), 0x100, test::keys(0x100), 1s);
  Picture picture;
  p.published.draw(p.sessions, 1s);
  EXPECT_FALSE(p.published.pictures().take(picture));  // asks for one
  p.published.draw(p.sessions, 2s);
  p.published.draw(p.sessions, 3s);
  ASSERT_TRUE(p.published.pictures().take(picture));
  EXPECT_EQ(picture.time, 2s);
  EXPECT_EQ(picture.version, 1u);
  EXPECT_EQ(picture.hands.size(), 1u);
}

TEST(PublishedScene, ARecorderHasPicturesOfItsOwn) {
  for (const bool recorded : {false, true}) {
    Published p(recorded);
    Picture picture;
    p.published.recorded_pictures().take(picture);
    p.published.draw(p.sessions, 1s);
    EXPECT_EQ(p.published.recorded_pictures().take(picture), recorded);
    EXPECT_FALSE(p.published.pictures().take(picture));
  }
}

}  // namespace
}  // namespace feltwire::published_scene_test
