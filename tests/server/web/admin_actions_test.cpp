// The actions of admins alone: a scene that answers when the test lets it, and no socket.

#include "server/web/admin_actions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "protocol/net/clock.hpp"
#include "server/web/viewed_scene.hpp"
#include "tests/server/web/page_fakes.hpp"
#include "tests/support/security.hpp"

namespace feltwire::web::admin_actions_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Outcome = AdminActions::Outcome;
using Recorded = std::function<void(std::variant<control::SceneRecordings, control::Refused>)>;
using Written = std::function<void(std::variant<std::string, control::Refused>)>;

class AdminActionsTest : public ::testing::Test {
 protected:
  AdminActionsTest() { describe(7); }

  ViewerSlot& add(ViewerId id, test::FakeViewer& viewer, const IssuedToken& token) {
    ViewerSlot& slot =
        slots_.try_emplace(id, id, &viewer, asio::ip::make_address("127.0.0.1")).first->second;
    slot.token = token.token.id;
    slot.client = token.token.client;
    slot.scene = &viewed_;
    return slot;
  }
  /// The scene has one session with this id.
  void describe(std::uint64_t session) {
    HandDescription hand;
    hand.session = session;
    viewed_.hands() = {hand};
  }
  static ViewerMessage says(const std::string& text) { return *parse_viewer_message(text); }

  IssuedToken eye_ = issue_token("eye", "*", Role::observer, std::nullopt),
              other_ = issue_token("other", "elsewhere", Role::admin, std::nullopt);
  asio::io_context io_;
  test::FakeScene scene_;
  ViewedScene viewed_{io_, scene_, 3, Nanoseconds{0}};
  ViewerTokens tokens_{test::security({eye_.token, other_.token}).tokens};
  test::FakeViewer viewer_;
  ViewTickets tickets_;
  ViewerSlots slots_;
  std::vector<std::size_t> reloads_;
  Written written_;
  Recorded recorded_;
  std::vector<control::RecordingAction> actions_asked_;
  std::unique_ptr<AdminActions> actions_ = std::make_unique<AdminActions>(
      io_, tokens_, tickets_, slots_,
      AdminActions::Callbacks{
          .reload = [this](std::size_t scene) { reloads_.push_back(scene); },
          .write_flight = [this](std::size_t, Written done) { written_ = std::move(done); },
          .record =
              [this](std::size_t, control::RecordingAction action, Recorded done) {
                actions_asked_.push_back(action);
                recorded_ = std::move(done);
              }});
  ViewerSlot& slot_ = add(1, viewer_, test::admin_token());
};

constexpr const char* kChange = R"({"set":{"object":"floor","stiffness":900}})";

TEST_F(AdminActionsTest, LeaveOtherMessagesAlone) {
  EXPECT_EQ(actions_->handle(slot_, says(R"({"watch":"room"})")), Outcome::not_asked);
  EXPECT_THAT(viewer_.take(), IsEmpty());
}

TEST_F(AdminActionsTest, AreForAdminsOnly) {
  test::FakeViewer observer;
  ViewerSlot& slot = add(2, observer, eye_);
  EXPECT_FALSE(actions_->is_admin(slot));
  for (const char* asked : {kChange, R"({"reload":true})", R"({"evict":"7"})", R"({"record":true})",
                            R"({"recording":"start"})", R"({"download":"a.mcap"})"}) {
    EXPECT_EQ(actions_->handle(slot, says(asked)), Outcome::handled);
    EXPECT_THAT(observer.take(), ElementsAre(HasSubstr("for admins of the scene")));
  }
  EXPECT_TRUE(scene_.changes.empty() && scene_.evicted.empty() && reloads_.empty());
}

TEST_F(AdminActionsTest, ASecondTokenMakesAnAdmin) {
  test::FakeViewer observer;
  ViewerSlot& slot = add(2, observer, eye_);
  EXPECT_EQ(actions_->handle(slot, says(R"({"admin":"fw_wrong"})")), Outcome::wrong_token);
  EXPECT_THAT(observer.take(), IsEmpty());
  const auto shows = [](const Secret& token) {
    return says(R"({"admin":")" + std::string(token.text()) + "\"}");
  };
  EXPECT_EQ(actions_->handle(slot, shows(other_.text)), Outcome::handled);
  EXPECT_THAT(observer.take(), ElementsAre(HasSubstr("not of an admin of this scene")));
  EXPECT_FALSE(actions_->is_admin(slot));
  EXPECT_EQ(actions_->handle(slot, shows(test::admin_token().text)), Outcome::handled);
  EXPECT_THAT(observer.take(), ElementsAre(HasSubstr("\"admin\"")));
  EXPECT_TRUE(actions_->is_admin(slot));
}

TEST_F(AdminActionsTest, AChangeIsAnsweredWhenTheSceneHasMadeIt) {
  actions_->handle(slot_, says(kChange));
  EXPECT_THAT(viewer_.take(), IsEmpty());
  ASSERT_EQ(scene_.changes.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<MaterialChange>(scene_.changes.front()));
  scene_.done_changes.front()("made");
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("made")));
  scene_.done_changes.front()(control::Refused{control::RefusalCode::bad_parameters, "no"});
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("refused")));
}

TEST_F(AdminActionsTest, ALateAnswerFindsNobody) {
  actions_->handle(slot_, says(kChange));
  actions_->handle(slot_, says(R"({"record":true})"));
  slots_.clear();
  scene_.done_changes.front()("made");
  written_("flight.mcap");
  io_.run();
  actions_.reset();
  scene_.done_changes.front()("made");
  EXPECT_THAT(viewer_.take(), IsEmpty());
}

TEST_F(AdminActionsTest, TheNextChangeBuildsOnTheLast) {
  SessionParameters parameters;
  parameters.side = BoundingSide::server;
  viewed_.hands().front().parameters = parameters;
  actions_->handle(slot_, says(R"({"set":{"session":"7","velocity_cutoff":80}})"));
  scene_.done_changes.front()("made");
  actions_->handle(slot_, says(R"({"set":{"session":"7","operator_damping":0.25}})"));
  ASSERT_EQ(scene_.changes.size(), 2u);
  const auto& second = std::get<ParameterChange>(scene_.changes.back());
  EXPECT_EQ(second.session, 7u);
  EXPECT_EQ(second.parameters.velocity_cutoff, 80.0);
  EXPECT_EQ(second.parameters.operator_damping, 0.25);
}

TEST_F(AdminActionsTest, EvictAndReloadNameTheirTargets) {
  actions_->handle(slot_, says(R"({"evict":"7"})"));
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("evicted")));
  actions_->handle(slot_, says(R"({"evict":"8"})"));
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("there is no session 8")));
  EXPECT_THAT(scene_.evicted, ElementsAre(7u));
  actions_->handle(slot_, says(R"({"reload":true})"));
  EXPECT_THAT(reloads_, ElementsAre(3u));
}

TEST_F(AdminActionsTest, AFlightRecordIsAnsweredOnThePagesThread) {
  actions_->handle(slot_, says(R"({"record":true})"));
  written_("flight.mcap");
  EXPECT_THAT(viewer_.take(), IsEmpty());
  io_.run();
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("flight record: flight.mcap")));
}

/// Only admins of the scene are told of its recordings, once for each change.
TEST_F(AdminActionsTest, RecordingsAreToldToAdmins) {
  test::FakeViewer observer, second;
  add(2, observer, eye_);
  add(3, second, test::admin_token());
  const control::SceneRecordings runs{"room", "", "a.mcap"};
  actions_->handle(slot_, says(R"({"recording":"start"})"));
  EXPECT_THAT(actions_asked_, ElementsAre(control::RecordingAction::start));
  recorded_(runs);
  EXPECT_THAT(viewer_.take(), IsEmpty());
  io_.run();
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("\"running\": \"a.mcap\"")));
  EXPECT_THAT(second.take(), ElementsAre(HasSubstr("\"running\": \"a.mcap\"")));
  EXPECT_THAT(observer.take(), IsEmpty());
  const auto look = [&](int seconds, const control::SceneRecordings& told) {
    actions_->look_after(std::chrono::seconds(seconds));
    if (recorded_) std::exchange(recorded_, {})(told);
    io_.restart();
    io_.run();
  };
  recorded_ = {};
  look(10, runs);
  EXPECT_THAT(viewer_.take(), IsEmpty());
  look(11, {"room", "", "a.mcap", 1.0});
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("\"seconds\": 1,")));
  actions_->look_after(std::chrono::seconds(11));  // It asks once a second.
  EXPECT_FALSE(recorded_);
}

TEST_F(AdminActionsTest, ATicketForARecordingIsVoidWithItsTokensRight) {
  const control::SceneRecordings kept{
      "room", "/records", "", 0.0, 0, control::RecordingEnd::none, {{"a.mcap", 7}}};
  const auto ticket = [&] {
    actions_->handle(slot_, says(R"({"download":"a.mcap"})"));
    recorded_(kept);
    io_.restart();
    io_.run();
    const std::string said = viewer_.take().at(0);
    const std::size_t begin = said.find("fw_");
    return said.substr(begin, said.find('"', begin) - begin);
  };
  const std::string good = ticket();
  EXPECT_EQ(actions_->redeem_download(good), std::filesystem::path("/records/a.mcap"));
  EXPECT_EQ(actions_->redeem_download(good), std::nullopt);
  EXPECT_EQ(actions_->redeem_download("fw_wrong"), std::nullopt);
  const Secret watching = tickets_.mint(test::admin_token().token, "room", calendar_now());
  EXPECT_EQ(actions_->redeem_download(watching.text()), std::nullopt);
  const Secret of_observer = tickets_.mint(eye_.token, "room", calendar_now(), "/records/a.mcap");
  EXPECT_EQ(actions_->redeem_download(of_observer.text()), std::nullopt);
  const Secret of_other = tickets_.mint(other_.token, "room", calendar_now(), "/records/a.mcap");
  EXPECT_EQ(actions_->redeem_download(of_other.text()), std::nullopt);
}

TEST_F(AdminActionsTest, APageOfARemoteServerRefusesThem) {
  scene_.remote = true;
  EXPECT_EQ(actions_->handle(slot_, says(kChange)), Outcome::handled);
  EXPECT_THAT(viewer_.take(), ElementsAre(HasSubstr("only looks on")));
}

TEST_F(AdminActionsTest, AClientThatChangesTooMuchWaits) {
  for (int n = 0; n < 60; ++n) actions_->handle(slot_, says(kChange));
  EXPECT_THAT(viewer_.take(), IsEmpty());
  for (int n = 0; n < 60; ++n) actions_->handle(slot_, says(kChange));
  EXPECT_THAT(viewer_.take(), ::testing::Contains(HasSubstr("changes too much at once")));
}

}  // namespace
}  // namespace feltwire::web::admin_actions_test
