// An admin's changes on the live page must take effect. Other roles must be refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <tuple>

#include "core/scene_file/load_scene.hpp"
#include "server/web/viewer_message.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/moving.hpp"
#include "tests/server/resting_hand.hpp"
#include "tests/server/web/page_client.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::admin_page_test {
namespace {

using test::ControlClient;
using test::Page;
using test::RestingHand;
using ::testing::HasSubstr;
using Json = nlohmann::json;

Scene floor_of(double stiffness) {
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.material.stiffness = stiffness;
  return Scene("room", {floor});
}

class AdminPage : public ::testing::Test {
 protected:
  static std::vector<Scene> scenes() {
    std::vector<Scene> all;
    all.push_back(floor_of(500.0));
    return all;
  }
  static std::string token_text(const IssuedToken& token) { return std::string(token.text.text()); }

  IssuedToken eye_ = issue_token("eye", "*", Role::observer, std::nullopt),
              other_ = issue_token("other", "theatre", Role::admin, std::nullopt);
  Server server_{test::with_page(), scenes(), test::security({eye_.token, other_.token})};
  ControlClient client_{server_.control_port()};
  const std::string admin_ = std::string(test::admin_token().text.text());
};

TEST_F(AdminPage, AKnobChangesTheForce) {
  RestingHand hand(client_);
  EXPECT_NEAR(hand.force(), 0.5, 1e-9);
  Page page(server_, admin_), watcher(server_, token_text(eye_));
  EXPECT_EQ(page.text("hello")["role"], "admin");
  EXPECT_EQ(page.text("materials")["objects"][0]["stiffness"], 500.0);
  watcher.text("materials");
  page.say({{"set", {{"object", "floor"}, {"stiffness", 2000}}}});
  EXPECT_EQ(page.text("changed")["text"], "object 'floor': stiffness 500 -> 2000 [N/m]");
  EXPECT_NEAR(hand.force(), 2.0, 1e-9);
  // All viewers must get the new value without a new scene.
  const Json seen = watcher.text("materials");
  EXPECT_EQ(seen["objects"][0]["stiffness"], 2000.0);
  EXPECT_EQ(seen["version"], 1);
  EXPECT_TRUE(seen["gravity"].is_null());
  page.say({{"set", {{"object", "floor"}, {"stiffness", -1}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(),
              HasSubstr("stiffness: must be above zero [N/m], is -1"));
  page.say({{"set", {{"gravity", {0, 0, -1}}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("nothing moves"));
  EXPECT_NEAR(hand.force(), 2.0, 1e-9);
}

TEST_F(AdminPage, OnlyAnAdminOfTheSceneMay) {
  RestingHand hand(client_);
  Page page(server_, token_text(eye_));
  EXPECT_EQ(page.text("hello")["role"], "observer");
  for (const Json& asked : {Json{{"set", {{"object", "floor"}, {"stiffness", 1}}}},
                            Json{{"evict", std::to_string(hand.session())}}, Json{{"reload", true}},
                            Json{{"record", true}}, Json{{"recording", "start"}},
                            Json{{"download", "recording.mcap"}}}) {
    page.say(asked);
    EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("for admins"));
  }
  for (const auto& [token, says] : {std::pair{std::string("fw_wrong"), "unknown"},
                                    std::pair{token_text(other_), "of this scene"},
                                    std::pair{token_text(eye_), "its role is observer"}}) {
    page.say({{"admin", token}});
    EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr(says));
  }
  EXPECT_NEAR(hand.force(), 0.5, 1e-9);
  page.say({{"admin", admin_}});
  EXPECT_EQ(page.text("admin")["role"], "admin");
  page.say({{"set", {{"object", "floor"}, {"stiffness", 1000}}}});
  page.text("changed");
  EXPECT_NEAR(hand.force(), 1.0, 1e-9);
}

TEST_F(AdminPage, AsksForAFlightRecord) {
  Page none(server_, admin_);
  none.text("materials");
  none.say({{"record", true}});
  EXPECT_THAT(none.text("refused")["text"].get<std::string>(), HasSubstr("--flight-recorder DIR"));

  const testing::TemporaryFolder folder;
  ServerConfig config = test::with_page();
  config.recording.flight_folder = folder / "flights";
  Server server(config, scenes(), test::security());
  Page page(server, admin_);
  page.text("materials");
  page.say({{"record", true}});
  const std::string said = page.text("changed")["text"];
  ASSERT_THAT(said, ::testing::StartsWith("flight record: "));
  EXPECT_TRUE(std::filesystem::exists(said.substr(std::string("flight record: ").size()))) << said;
}

/// Returns the whole answer of the page's port to a request for this path.
std::string fetched(const Server& server, const std::string& path) {
  const std::string host = "127.0.0.1:" + std::to_string(test::page_port(server));
  test::RawSocket socket(SOCK_STREAM, test::page_port(server));
  socket.send(test::bytes("GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n"));
  std::string answer;
  for (auto part = socket.receive(65536); !part.empty(); part = socket.receive(65536))
    answer.append(part.begin(), part.end());
  return answer;
}

TEST_F(AdminPage, RecordsAtTheServerAndDownloadsTheFile) {
  Page none(server_, admin_);
  none.text("materials");
  none.say({{"recording", "start"}});
  EXPECT_THAT(none.text("refused")["text"].get<std::string>(), HasSubstr("--recordings DIR"));

  const testing::TemporaryFolder folder;
  ServerConfig config = test::with_page();
  config.recording.folder = folder / "recordings";
  Server server(config, scenes(), test::security({eye_.token}));
  Page page(server, admin_), second(server, admin_), watcher(server, token_text(eye_));
  watcher.text("materials");
  EXPECT_TRUE(page.text("recordings")["running"].is_null());
  page.say({{"recording", "start"}});
  Json told = page.text("recordings");
  const std::string name = told["running"];
  do told = second.text("recordings");
  while (told.at("running").is_null());
  EXPECT_EQ(told["running"], name);
  second.say({{"recording", "start"}});
  EXPECT_THAT(second.text("refused")["text"].get<std::string>(), HasSubstr("runs already"));
  page.say({{"recording", "pause"}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("start and stop"));

  const auto refused_download = [&](const std::string& wanted) {
    page.say({{"download", wanted}});
    return page.text("refused")["text"].get<std::string>();
  };
  EXPECT_THAT(refused_download(name), HasSubstr("no complete recording"));  // It still runs.
  second.say({{"recording", "stop"}});
  do told = page.text("recordings");
  while (told.at("kept").empty());
  EXPECT_EQ(told["kept"][0]["name"], name);
  for (const std::string wrong : {"", "../admin.token", "/etc/hostname", "recordings"})
    EXPECT_THAT(refused_download(wrong), HasSubstr("no complete recording"));

  page.say({{"download", name}});
  const Json ticket = page.text("download");
  EXPECT_EQ(ticket["name"], name);
  const std::string answer = fetched(server, ticket["path"]);
  EXPECT_THAT(answer, ::testing::StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Disposition: attachment; filename=\"" + name + "\"\r\n"));
  std::ifstream in(config.recording.folder / name, std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(answer.substr(answer.find("\r\n\r\n") + 4), file);
  EXPECT_EQ(file.size(), told["kept"][0]["bytes"].get<std::size_t>());
  EXPECT_THAT(fetched(server, ticket["path"]), ::testing::StartsWith("HTTP/1.1 403 "));
  EXPECT_THAT(fetched(server, "/recording"), ::testing::StartsWith("HTTP/1.1 403 "));
  // A ticket to watch is no ticket for a file.
  watcher.say({{"ticket", "room"}});
  const std::string watch = watcher.text("ticket")["path"];
  EXPECT_THAT(fetched(server, "/recording" + watch.substr(watch.find('?'))),
              ::testing::StartsWith("HTTP/1.1 403 "));

  page.say({{"download", name}});
  const std::string late = page.text("download")["path"];
  std::filesystem::remove(config.recording.folder / name);
  std::filesystem::create_symlink("/etc/hostname", config.recording.folder / name);
  EXPECT_THAT(fetched(server, late), ::testing::StartsWith("HTTP/1.1 404 "));
}

TEST_F(AdminPage, SetsTheBoundOfASessionAndEvictsIt) {
  SessionParameters parameters;
  parameters.side = BoundingSide::server;
  RestingHand hand(client_, parameters);
  hand.force();
  Page page(server_, admin_);
  // The page sends sessions twice a second, so wait for a session.
  Json session;
  while (session.is_null()) {
    const Json told = page.text("sessions");
    ASSERT_EQ(told["type"], "sessions");
    if (!told["sessions"].empty()) session = told["sessions"][0];
  }
  EXPECT_EQ(session["session"], std::to_string(hand.session()));
  page.say({{"set", {{"session", std::to_string(hand.session())}, {"mode", "per_axis"}}}});
  EXPECT_EQ(page.text("changed")["text"], "session 1 (tester): mode contact_frame -> per_axis");
  const std::string id = std::to_string(hand.session());
  const auto changed = [&](Json set) {
    set["session"] = id;
    page.say({{"set", std::move(set)}});
    return page.text("changed")["text"].get<std::string>();
  };
  for (const auto& [name, value, says] :
       {std::tuple{"operator_damping", 0.25, "0 -> 0.25"},
        std::tuple{"velocity_cutoff", 80.0, "0 -> 80"}, std::tuple{"c1", 400.0, "400"},
        std::tuple{"c2", 300.0, "300"}, std::tuple{"coupling_stiffness", 150.0, "150"},
        std::tuple{"coupling_damping", 0.1, "0.1"},
        std::tuple{"tool_mass", 0.125, "0.05 -> 0.125"}})
    EXPECT_THAT(changed({{name, value}}), ::testing::AllOf(HasSubstr(name), HasSubstr(says)));
  EXPECT_THAT(changed({{"reference", "following"}}), HasSubstr("zero -> following"));
  do session = page.text("sessions")["sessions"][0];
  while (session["reference"] != "following");
  EXPECT_EQ(session["tool_mass"], 0.125);
  EXPECT_EQ(session["c1"], 400.0);
  page.say({{"set", {{"session", id}, {"reference", "no_such"}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("no_such"));
  page.say({{"set", {{"session", id}, {"tool_mass", -1}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("tool_mass"));
  page.say({{"set", {{"session", std::to_string(hand.session())}, {"mode", "no_such"}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("no_such"));
  page.say({{"set", {{"session", "12"}, {"mode", "none"}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("no session 12"));
  EXPECT_TRUE(session["lead_share"].is_null()) << "the scene has no seat for a robot";
  page.say({{"set", {{"session", std::to_string(hand.session())}, {"lead_share", 0.5}}}});
  EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("no seat for a robot"));
  page.say({{"evict", std::to_string(hand.session())}});
  page.text("changed");
  const std::vector<SceneSummary> summary = server_.summary();
  EXPECT_EQ(summary[0].counters.evicted, 1u);
}

/// A floating body must fall with the gravity that an admin sets.
TEST(AdminPageGravity, MovesTheBodies) {
  const Vec3 place(0.2, 0, 0);
  std::vector<Object> objects = {test::object("ball", Sphere{0.03}, {.stiffness = 1000}, place)};
  const auto mechanism = compile(objects, {0}, {test::body("ball", 0.2, place)}, test::kWeightless);
  std::vector<Scene> scenes;
  scenes.emplace_back("room", objects).set_mechanism(mechanism);
  Server server(test::with_page(), std::move(scenes), test::security({}));
  ControlClient client(server.control_port());
  RestingHand hand(client);  // The scene moves only with a hand.
  hand.force();
  Page page(server, std::string(test::admin_token().text.text()));
  const auto height = [&] {  // the height of the ball, after the hand's data
    constexpr std::size_t kZ = 24 + 112 + 4 + 8;
    float z = 0.0f;
    const auto picture = page.picture();
    if (picture.size() >= kZ + sizeof z) std::memcpy(&z, picture.data() + kZ, sizeof z);
    return z;
  };
  EXPECT_EQ(page.text("materials")["gravity"], Json({0.0, 0.0, 0.0}));
  EXPECT_EQ(height(), 0.0f);
  page.say({{"set", {{"gravity", {0, 0, 9.81}}}}});
  EXPECT_THAT(page.text("changed")["text"].get<std::string>(),
              HasSubstr("gravity (0, 0, 0) -> (0, 0, 9.81) [m/s^2]"));
  EXPECT_EQ(page.text("materials")["gravity"], Json({0.0, 0.0, 9.81}));
  test::eventually("the ball to rise", [&] { return height() > 0.01f; });
}

/// An unknown request must end the connection, because no page sends it.
TEST(ViewerMessage, ReadsWhatAnAdminWants) {
  using web::parse_viewer_message;
  const auto all = parse_viewer_message(
      R"({"set":{"object":"floor","stiffness":5,"damping":0.5,"static_friction":1e0}})");
  ASSERT_TRUE(all && all->set);
  EXPECT_EQ(all->set->material,
            (MaterialChange{
                .object = "floor", .stiffness = 5.0, .damping = 0.5, .static_friction = 1.0}));
  EXPECT_FALSE(all->set->gravity);
  const auto gravity = parse_viewer_message(R"({"set":{"gravity":[0,-1,2.5]}})");
  ASSERT_TRUE(gravity && gravity->set);
  EXPECT_EQ(gravity->set->gravity, Vec3(0, -1, 2.5));
  const auto mode = parse_viewer_message(R"({"set":{"session":"7","mode":"none"},"reload":true})");
  ASSERT_TRUE(mode && mode->set);
  EXPECT_EQ(mode->set->session, "7");
  EXPECT_EQ(mode->set->bound.mode, "none");
  EXPECT_TRUE(mode->reload);
  EXPECT_FALSE(mode->record);
  EXPECT_TRUE(parse_viewer_message(R"({"record":true})")->record);
  EXPECT_EQ(parse_viewer_message(R"({"evict":"7"})")->evict, "7");
  EXPECT_EQ(parse_viewer_message(R"({"admin":"fw_1"})")->admin, "fw_1");
  for (const char* wrong :
       {R"({"set":7})", R"({"set":"x"})", R"({"set":[1]})", R"({"set":null})",
        R"({"set":{"gravity":[1,2]}})", R"({"set":{"gravity":[1,2,3,4]}})",
        R"({"set":{"gravity":[1,2,"3"]}})", R"({"set":{"gravity":7}})",
        R"({"set":{"stiffness":"5"}})", R"({"set":{"stiffness":[5]}})", R"({"set":{"stifness":5}})",
        R"({"set":{"stiffness":true}})", R"({"set":{"object":7}})", R"({"set":{"object":{}}})",
        R"({"set":{"gravity":[[1],2,3]}})", R"({"set":{"reload":true}})"})
    EXPECT_FALSE(parse_viewer_message(wrong)) << wrong;
}

TEST(AdminPageReload, IsToldToThoseWhoWatchAndWhatIsWrongToAdminsAlone) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  const std::string good = R"({"name": "room", "materials": [{"name": "m", "stiffness": 500}],
"objects": [{"name": "floor", "plane": {}, "material": "m"}]})";
  std::ofstream(file) << good;
  const IssuedToken eye = issue_token("eye", "*", Role::observer, std::nullopt);
  ServerConfig config = test::with_page();
  config.scenes = {file};
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(file));
  Server server(config, std::move(scenes), test::security({eye.token}));
  ControlClient client(server.control_port());
  RestingHand hand(client);
  Page page(server, std::string(test::admin_token().text.text())),
      watcher(server, std::string(eye.text.text()));
  page.text("materials");
  watcher.text("materials");
  page.say({{"set", {{"object", "floor"}, {"stiffness", 4000}}}});
  page.text("changed");
  EXPECT_NEAR(hand.force(), 4.0, 1e-9);
  std::ofstream(file) << R"({"name": "room", "objects": [{"name": "floor", "plan": {}}]})";
  page.say({{"reload", true}});
  const Json wrong = page.text("log");
  EXPECT_EQ(wrong["level"], "error");
  EXPECT_THAT(wrong["text"].get<std::string>(), HasSubstr("room.json:1"));
  EXPECT_NEAR(hand.force(), 4.0, 1e-9);
  std::ofstream(file) << good;
  page.say({{"reload", true}});
  EXPECT_EQ(page.text("log")["level"], "info");
  // The watcher must not get the line about the file. The watcher's first line is about the reload.
  EXPECT_EQ(watcher.text("log")["text"], "Scene room was reloaded from its file.");
  EXPECT_NEAR(hand.force(), 0.5, 1e-9);  // the value of the file
}

}  // namespace
}  // namespace feltwire::admin_page_test
