// A scene for its viewers: which message each of them gets, and when.

#include "server/web/viewed_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "tests/server/web/page_fakes.hpp"

namespace feltwire::web::viewed_scene_test {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ViewedSceneTest : public ::testing::Test {
 protected:
  /// A turn of the page. Returns the texts that the viewer got.
  std::vector<std::string> turn(Nanoseconds now = 10s) {
    viewed_.show(std::array{&slot_}, now);
    return viewer_.take();
  }
  void give_picture(std::uint32_t version) {
    scene_.picture.emplace();
    scene_.picture->version = version;
  }

  asio::io_context io_;
  test::FakeScene scene_;
  ViewedScene viewed_{io_, scene_, 0, Nanoseconds{0}};
  test::FakeViewer viewer_;
  ViewerSlot slot_{1, &viewer_, asio::ip::make_address("127.0.0.1")};
};

TEST_F(ViewedSceneTest, SendsTheSceneOnceAndAgainAfterAReload) {
  EXPECT_THAT(turn(), Contains(HasSubstr("\"scene\"")));
  EXPECT_THAT(turn(), IsEmpty());
  ++scene_.current.version;
  EXPECT_THAT(turn(), Contains(HasSubstr("\"scene\"")));
}

TEST_F(ViewedSceneTest, SendsMaterialsAfterALiveChange) {
  turn();
  ++scene_.current.changes;
  EXPECT_THAT(turn(), ElementsAre(HasSubstr("\"materials\"")));
  EXPECT_THAT(turn(), IsEmpty());
}

TEST_F(ViewedSceneTest, SendsPicturesOfTheShownVersionOnly) {
  turn();
  const int before = viewer_.binaries;
  give_picture(2);
  turn();
  EXPECT_EQ(viewer_.binaries, before);
  give_picture(1);
  turn();
  EXPECT_EQ(viewer_.binaries, before + 1);
  EXPECT_EQ(viewed_.pictures(), 1u);
}

TEST_F(ViewedSceneTest, ASlowViewerGetsNothing) {
  viewer_.is_ready = false;
  give_picture(1);
  EXPECT_THAT(turn(), IsEmpty());
  EXPECT_EQ(viewer_.binaries, 0);
  EXPECT_EQ(viewed_.skipped(), 1u);
  EXPECT_EQ(viewed_.pictures(), 0u);
}

TEST_F(ViewedSceneTest, DescribesTheHandsTwiceASecond) {
  EXPECT_THAT(turn(10s), Contains(HasSubstr("\"sessions\"")));
  ASSERT_EQ(scene_.describes.size(), 1u);
  EXPECT_THAT(turn(11s), IsEmpty());  // no answer to the first question yet
  HandDescription hand;
  hand.session = 77;
  scene_.describes.front()({hand});
  EXPECT_EQ(viewed_.hands().size(), 1u);
  EXPECT_THAT(turn(10400ms), IsEmpty());
  EXPECT_THAT(turn(10500ms), ElementsAre(HasSubstr("\"77\"")));
}

TEST_F(ViewedSceneTest, ADescriptionMayComeTooLate) {
  {
    ViewedScene gone(io_, scene_, 0, Nanoseconds{0});
    gone.show(std::array{&slot_}, 10s);
  }
  scene_.describes.front()({});
}

TEST_F(ViewedSceneTest, TellsWhenTheSceneIsLostFromViewAndBack) {
  turn();
  scene_.hidden = "the server is away";
  EXPECT_THAT(turn(), ElementsAre(HasSubstr("the server is away")));
  EXPECT_THAT(turn(), IsEmpty());
  scene_.hidden.reset();
  EXPECT_THAT(turn(), ElementsAre(HasSubstr("is seen")));
}

TEST_F(ViewedSceneTest, AFoxgloveViewerGetsNoMessageOfThePage) {
  slot_.foxglove.emplace(viewer_, viewed_.name());
  viewer_.take();
  give_picture(1);
  EXPECT_THAT(turn(), Each(Not(HasSubstr("\"scene\""))));
  EXPECT_EQ(viewed_.pictures(), 1u);
}

}  // namespace
}  // namespace feltwire::web::viewed_scene_test
