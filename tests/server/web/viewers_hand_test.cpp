#include "server/web/viewers_hand.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace feltwire::web::viewers_hand_test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

struct FakeHand : PageHand {
  Status now;
  std::vector<Vec3> points;
  int releases = 0;
  Status status() const override { return now; }
  void point(const Vec3& target) noexcept override { points.push_back(target); }
  void release() noexcept override { ++releases; }
};

struct FakeHands : PageHands {
  std::shared_ptr<FakeHand> next = std::make_shared<FakeHand>();
  int taken = 0;
  PageHandRequest asked;
  std::shared_ptr<PageHand> take(const PageHandRequest& request) override {
    ++taken;
    asked = request;
    return next;
  }
  void trust(const Fingerprint& /*fingerprint*/) override {}
};

Json news(ViewersHand& hand) {
  const auto text = hand.news();
  return text ? Json::parse(*text) : Json();
}

TEST(ViewersHand, HasTheLawThatItsViewerChose) {
  FakeHands hands;
  ViewersHand usual(hands, "anna", Secret("fw_1"));
  usual.take("room");
  EXPECT_EQ(hands.asked.mode, "");
  ViewersHand hand(hands, "anna", Secret("fw_1"));
  EXPECT_EQ(news(hand)["state"], "free");
  hand.take("room", "no_law");
  EXPECT_EQ(hands.taken, 1);
  const Json refused = news(hand);
  EXPECT_EQ(refused["state"], "refused");
  EXPECT_THAT(refused["reason"].get<std::string>(),
              ::testing::StartsWith("there is no law 'no_law'; choose "));
  hand.take("room", "per_axis");
  EXPECT_EQ(hands.taken, 2);
  EXPECT_EQ(hands.asked.mode, "per_axis");
}

TEST(ViewersHand, TellsItsStoryOnce) {
  FakeHands hands;
  ViewersHand hand(hands, "anna", Secret("fw_1"));
  EXPECT_EQ(news(hand), Json({{"type", "hand"}, {"state", "free"}}));
  EXPECT_TRUE(news(hand).is_null());
  hand.take("room");
  EXPECT_EQ(hands.asked.scene, "room");
  EXPECT_EQ(hands.asked.client, "anna");
  EXPECT_EQ(hands.asked.token.text(), "fw_1");
  EXPECT_EQ(news(hand)["state"], "joining");
  EXPECT_TRUE(news(hand).is_null());
  hands.next->now = {.state = PageHand::State::held,
                     .session = 1ull << 60,
                     .start = Vec3(0.5, -1, 0.25),
                     .stiffness = 300,
                     .reach = 0.02};
  const Json held = news(hand);
  EXPECT_EQ(held["state"], "held");
  EXPECT_EQ(held["session"], "1152921504606846976");  // too large for a JavaScript number
  EXPECT_EQ(held["start"], Json({0.5, -1, 0.25}));
  EXPECT_EQ(held["reach"], 0.02);
  hands.next->now = {.state = PageHand::State::released, .reason = "it was enough"};
  EXPECT_EQ(news(hand)["reason"], "it was enough");
  EXPECT_TRUE(news(hand).is_null());
  hand.take("room");  // The viewer takes another hand.
  EXPECT_EQ(hands.taken, 2);
}

TEST(ViewersHand, HoldsOneAtATime) {
  FakeHands hands;
  ViewersHand hand(hands, "anna", Secret("fw_1"));
  hand.take("room");
  hand.take("room");
  EXPECT_EQ(hands.taken, 1);
}

TEST(ViewersHand, SaysWhyThereIsNone) {
  ViewersHand nobody;
  EXPECT_TRUE(news(nobody).is_null());
  nobody.take("room");
  EXPECT_THAT(news(nobody)["reason"].get<std::string>(), HasSubstr("role"));

  FakeHands hands;
  ViewersHand hand(hands, "anna", Secret("fw_1"));
  news(hand);
  hands.next = nullptr;
  hand.take("room");
  EXPECT_THAT(news(hand)["reason"].get<std::string>(), HasSubstr("--web-hands"));
}

TEST(ViewersHand, PointsNowhereWhereNoHandCanBe) {
  FakeHands hands;
  ViewersHand hand(hands, "anna", Secret("fw_1"));
  EXPECT_TRUE(hand.point(Vec3::Zero()));  // A viewer may send a point before it has a hand.
  hand.take("room");
  EXPECT_TRUE(hand.point(Vec3(0.1, 0, -10)));
  for (const double wrong : {1e9, -10.001, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()})
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 target = Vec3::Zero();
      target[axis] = wrong;
      EXPECT_FALSE(hand.point(target)) << wrong;
    }
  ASSERT_EQ(hands.next->points.size(), 1u);
  EXPECT_EQ(hands.next->points[0], Vec3(0.1, 0, -10));
}

TEST(ViewersHand, IsReleasedWithItsViewer) {
  FakeHands hands;
  {
    ViewersHand hand(hands, "anna", Secret("fw_1"));
    hand.take("room");
  }
  EXPECT_EQ(hands.next->releases, 1);
}

}  // namespace
}  // namespace feltwire::web::viewers_hand_test
