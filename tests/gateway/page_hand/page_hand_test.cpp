// Tests hands of the live page over real sockets, from a browser's WebSocket to the scene.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "client/transport/control_client.hpp"
#include "core/bounding/method.hpp"
#include "gateway/page_hand/make_page_hands.hpp"
#include "server/app/server.hpp"
#include "tests/server/make.hpp"
#include "tests/server/web/page_client.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"

namespace feltwire::page_hand_test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;
using test::Page;

constexpr std::chrono::milliseconds kTimeout{10'000};

struct Stage {
  IssuedToken pointer = issue_token("anna", "*", Role::pointer, std::nullopt);
  IssuedToken observer = issue_token("eye", "*", Role::observer, std::nullopt);
  Server server;

  explicit Stage(int hands = 4)
      : server(config(hands), {test::room(0.0)}, test::security({pointer.token, observer.token}),
               load_scene_and_warn, make_page_hands) {}
  static ServerConfig config(int hands) {
    ServerConfig config = test::any_port();
    config.web = "0";
    config.web_hands = hands;
    return config;
  }
  Page page(const IssuedToken& token) const { return {server, std::string(token.text.text())}; }
  std::size_t sessions() const { return server.summary().front().sessions; }
  ServerAccess access(const IssuedToken& token) const {
    return test::access(server.control_port(), "127.0.0.1", token.text);
  }
};

/// Returns the server's next message about the viewer's own hand. Without a hand the message has no
/// state.
Json next_word(Page& page) { return page.text("hand"); }

/// Requests a hand. Returns the server's message after it gives or refuses the hand.
Json ask_for_hand(Page& page, const Json& request = {{"hand", "take"}}) {
  page.say(request);
  Json said = next_word(page);
  while (said["state"] == "joining") said = next_word(page);
  return said;
}
Json take(Page& page) {
  EXPECT_EQ(next_word(page)["state"], "free");
  return ask_for_hand(page);
}

/// The only hand of a picture.
struct HandInPicture {
  bool there = false;
  double z = 0.0, proxy_z = 0.0, force = 0.0, held = 0.0;
};
HandInPicture only_hand(const std::vector<std::uint8_t>& picture) {
  constexpr std::size_t kHand = 24, kFloats = kHand + 8;
  std::uint32_t hands = 0;
  if (picture.size() >= kHand) std::memcpy(&hands, picture.data() + 4, sizeof hands);
  if (hands != 1) return {};
  const auto at = [&](std::size_t i) {
    float value = 0.0f;
    std::memcpy(&value, picture.data() + kFloats + 4 * i, sizeof value);
    return double{value};
  };
  return {true, at(2), at(9), at(12), at(18)};
}

/// Points to `target` with every picture that arrives, until `condition` is true.
template <class Condition>
void point_until(const std::string& what, Page& page, const Vec3& target, Condition condition) {
  test::eventually(what, [&] {
    page.say({{"point", {target.x(), target.y(), target.z()}}});
    return condition(only_hand(page.picture()));
  });
}

TEST(PageHand, PressesAWallAndFeelsIt) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  const Json held = take(page);
  ASSERT_EQ(held["state"], "held") << held;
  EXPECT_EQ(held["start"], Json({0.01, 0.0, 0.02}));
  Page other = stage.page(stage.observer);
  // The arm's spring of 300 N/m has a target 10 mm below a floor of 2000 N/m. The depth is 1.3 mm
  // and the force 2.6 N.
  HandInPicture last;
  point_until("2 N", page, Vec3(0.01, 0, -0.01), [&](const HandInPicture& seen) {
    last = seen;
    EXPECT_GT(seen.there ? seen.z : 0.0, -0.008);  // depth during the impact
    return seen.there && seen.z > -0.002 && seen.force > 2.0 && seen.held > 1.5;
  });
  EXPECT_NEAR(last.force, -2000.0 * last.z, 0.3 * last.force);
  EXPECT_NEAR(last.proxy_z, 0.0, 1e-4);
  // Other viewers must see the hand too.
  point_until("another viewer sees it", page, Vec3(0.01, 0, -0.01),
              [&](const HandInPicture&) { return only_hand(other.picture()).force > 1.0; });
  point_until("it comes out again", page, Vec3(0.01, 0, 0.02), [](const HandInPicture& seen) {
    return seen.there && seen.z > 0.015 && seen.held == 0.0;
  });
  page.say({{"hand", "release"}});
  const Json released = next_word(page);
  EXPECT_EQ(released["state"], "released");
  test::eventually("its session ends", [&] { return stage.sessions() == 0; });
  EXPECT_EQ(stage.server.summary().front().counters.left, 1u);
  EXPECT_EQ(ask_for_hand(page)["state"], "held");  // a second hand
}

/// The hand is simulated, so a method without a bound is harmless.
TEST(PageHand, HasEachLawThatItIsTakenWith) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  ASSERT_EQ(next_word(page)["state"], "free");
  for (const std::string_view law : bounding_method_names()) {
    const Json held = ask_for_hand(page, {{"hand", "take"}, {"mode", law}});
    ASSERT_EQ(held["state"], "held") << law << ": " << held;
    const control::Message answer =
        ask(stage.access(test::admin_token()), control::DescribeSessions{"room", 0}, kTimeout);
    const auto& sessions = std::get<control::SessionDescriptions>(answer).sessions;
    ASSERT_EQ(sessions.size(), 1u) << law;
    EXPECT_EQ(std::string_view(sessions.front().parameters.mode), law);
    page.say({{"hand", "release"}});
    EXPECT_EQ(next_word(page)["state"], "released");
    test::eventually("its session ends", [&] { return stage.sessions() == 0; });
  }
  EXPECT_EQ(ask_for_hand(page, {{"hand", "take"}, {"mode", "no_law"}})["state"], "refused");
}

TEST(PageHand, LetsGoWhenThePageSaysNothing) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  ASSERT_EQ(take(page)["state"], "held");
  page.say({{"point", {0.01, 0, -0.005}}});  // The hand presses meanwhile.
  const Json released = next_word(page);
  EXPECT_EQ(released["state"], "released");
  EXPECT_THAT(released["reason"].get<std::string>(), HasSubstr("said nothing"));
  test::eventually("its session ends", [&] { return stage.sessions() == 0; });
}

TEST(PageHand, GoesWithItsPage) {
  const Stage stage;
  {
    Page page = stage.page(stage.pointer);
    ASSERT_EQ(take(page)["state"], "held");
    EXPECT_EQ(stage.sessions(), 1u);
  }
  test::eventually("its session ends", [&] { return stage.sessions() == 0; });
  EXPECT_EQ(stage.server.summary().front().counters.left, 1u);
}

TEST(PageHand, EndsWithTheServer) {
  auto stage = std::make_unique<Stage>();
  Page page = stage->page(stage->pointer);
  ASSERT_EQ(take(page)["state"], "held");
  stage->server.stop();
  EXPECT_EQ(stage->sessions(), 0u);
  EXPECT_EQ(page.close().code(), 1001);
}

TEST(PageHand, NeedsARoleThatHoldsOne) {
  const Stage stage;
  Page page = stage.page(stage.observer);
  page.say({{"hand", "take"}});
  const Json refused = next_word(page);
  EXPECT_EQ(refused["state"], "refused");
  EXPECT_THAT(refused["reason"].get<std::string>(), HasSubstr("role"));
  EXPECT_EQ(stage.sessions(), 0u);
}

TEST(PageHand, IsOneOfSoMany) {
  const Stage stage(1);
  Page first = stage.page(stage.pointer);
  ASSERT_EQ(take(first)["state"], "held");
  Page second = stage.page(stage.pointer);
  const Json refused = take(second);
  EXPECT_EQ(refused["state"], "refused");
  EXPECT_THAT(refused["reason"].get<std::string>(), HasSubstr("--web-hands"));
}

TEST(PageHand, IsNotLentWhereNoneIsAllowed) {
  const Stage stage(0);
  Page page = stage.page(stage.pointer);
  page.say({{"hand", "take"}});
  EXPECT_EQ(next_word(page)["state"], "refused");
}

TEST(PageHand, StaysWherePlacesAreHostile) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  ASSERT_EQ(take(page)["state"], "held");
  const std::vector<Json> hostile = {Json::array({1e9, 0, 0}), Json::array({0, 0, -1e300}),
                                     Json::array({1, 2}), Json::array({1, 2, 3, 4}),
                                     Json::array({"0", "0", "0"})};
  for (const Json& point : hostile) page.say({{"point", point}});
  point_until("a picture of it", page, Vec3(0.01, 0, 0.02),
              [](const HandInPicture& seen) { return seen.there; });
  for (int i = 0; i < 5; ++i) {
    for (const Json& point : hostile) page.say({{"point", point}});
    page.say({{"point", {0.01, 0, 0.02}}});
    EXPECT_NEAR(only_hand(page.picture()).z, 0.02, 1e-3);
  }
  test::RawSocket asked(SOCK_STREAM, test::page_port(stage.server));
  asked.send(test::bytes("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
  std::string all;
  for (auto more = asked.receive(); !more.empty(); more = asked.receive())
    all.append(more.begin(), more.end());
  EXPECT_THAT(all, HasSubstr("feltwire_page_points_refused_total 30\n"));
  EXPECT_THAT(all, HasSubstr("feltwire_page_hands_total 1\n"));
}

TEST(PageHand, OfAPageThatFloodsIsTakenAway) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  ASSERT_EQ(take(page)["state"], "held");
  for (int i = 0; i < 400; ++i) page.say({{"point", {0, 0, 0.02}}});
  EXPECT_EQ(page.close().code(), 4400);
  test::eventually("its session ends", [&] { return stage.sessions() == 0; });
}

TEST(PageHand, IsEvictedByAnAdmin) {
  const Stage stage;
  Page page = stage.page(stage.pointer);
  const Json held = take(page);
  ASSERT_EQ(held["state"], "held");
  const std::uint64_t session = std::stoull(held["session"].get<std::string>());
  ask(stage.access(test::admin_token()), control::Evict{session}, kTimeout);
  const Json released = next_word(page);
  EXPECT_EQ(released["state"], "released");
  EXPECT_THAT(released["reason"].get<std::string>(), HasSubstr("admin"));
}

// Only the server grants the rights, for any client of its control port.

control::JoinRequest pointer_request() {
  control::JoinRequest request = test::join_request(usual_parameters());
  request.device.max_force = 10.0;
  request.role = Role::pointer;
  return request;
}

std::string refusal(const Stage& stage, const IssuedToken& token,
                    const control::JoinRequest& request) {
  try {
    join(stage.access(token), request, kTimeout);
  } catch (const SessionError& error) {
    return error.what();
  }
  return {};
}

TEST(Pointer, JoinsWithASmallHandOnly) {
  const Stage stage(2);
  control::JoinRequest request = pointer_request();
  EXPECT_EQ(refusal(stage, stage.pointer, request), "");
  EXPECT_THAT(refusal(stage, stage.observer, request), HasSubstr("observer"));
  request.role = Role::operator_;
  EXPECT_THAT(refusal(stage, stage.pointer, request), HasSubstr("does not join as operator"));
  request = pointer_request();
  request.device.max_force = 10.1;
  EXPECT_THAT(refusal(stage, stage.pointer, request), HasSubstr("at most 10 N"));
  request = pointer_request();
  request.parameters.servo_period = 0.5e-3;
  EXPECT_THAT(refusal(stage, stage.pointer, request), HasSubstr("1000 samples"));
  EXPECT_EQ(refusal(stage, stage.pointer, pointer_request()), "");
  EXPECT_THAT(refusal(stage, stage.pointer, pointer_request()), HasSubstr("--web-hands"));
  // An operator may join with this hand.
  EXPECT_EQ(refusal(stage, test::admin_token(), test::join_request()), "");
}

}  // namespace
}  // namespace feltwire::page_hand_test
