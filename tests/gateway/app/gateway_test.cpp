// Tests a server, a gateway that observes it, and the gateway's viewers, over real sockets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/gateway/app/looking_gateway.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::gateway_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;

template <class Value>
Value at(const std::vector<std::uint8_t>& bytes, std::size_t place) {
  Value value{};
  if (place + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}
constexpr std::size_t kHand = 24, kElasticZ = kHand + 8 + 4 * (3 + 4 + 3 + 2), kZ = kHand + 16,
                      kHeldZ = kHand + 8 + 4 * (3 + 4 + 3 + 3 + 3 + 2);

void expect_hand(Page& page, double z, double force) {
  test::eventually("a picture of the hand at " + std::to_string(z), [&] {
    const auto picture = page.picture();
    return at<std::uint32_t>(picture, 4) == 1 && at<float>(picture, kZ) == static_cast<float>(z) &&
           at<float>(picture, kHeldZ) == static_cast<float>(force);
  });
}

TEST(Gateway, ShowsAHandThatMoves) {
  Server server = server_at();
  Hand hand(server);
  hand.put(0.003);
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway);
  EXPECT_EQ(page.text("hello")["scenes"], Json({"room"}));
  EXPECT_EQ(page.text("scene")["objects"][1]["name"], "ball");
  expect_hand(page, 0.003, 0.0);
  hand.put(-0.002, 2.5);
  expect_hand(page, -0.002, 2.5);
  // The server's stiffness is 2000 N/m.
  test::eventually("a picture with the elastic force",
                   [&] { return std::abs(at<float>(page.picture(), kElasticZ) - 4.0f) < 1e-4f; });
  test::eventually("the sessions' table", [&] {
    const Json said = page.text("sessions")["sessions"];
    return said.size() == 1 && said[0]["number"] == 1 && said[0]["samples"] == 2 &&
           said[0]["late_ticks"] == 5 && !said[0]["client"].is_null();
  });
  // The gateway must be a single observer for the server, for any number of viewers.
  EXPECT_EQ(server.summary().front().sessions, 2u);
}

TEST(Gateway, ShowsTheSurfacesNearAHandAsTheServerDoes) {
  ServerConfig config = test::any_port();
  config.web = "0";
  Server server(config, one(test::room(0.0)), test::security({observer().token}));
  SessionParameters renders;
  renders.local_model = true;
  Hand hand(server, renders);
  hand.put(0.003);
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway), original(server, std::string(observer().text.text()));
  const auto expected = original.surfaces(), seen = page.surfaces();
  constexpr std::size_t kHead = 12, kPatch = 60, kNumbers = 8;
  ASSERT_GT(expected.size(), kHead);
  ASSERT_EQ(seen.size(), expected.size());
  for (std::size_t patch = kHead; patch < seen.size(); patch += kPatch) {
    // the object number
    EXPECT_EQ(at<std::uint64_t>(seen, patch), at<std::uint64_t>(expected, patch));
    for (std::size_t i = patch + kNumbers; i < patch + kPatch; i += sizeof(float))
      EXPECT_NEAR(at<float>(seen, i), at<float>(expected, i), 1e-6f);
  }
}

/// The gateway's page must show the values of the server's page.
TEST(Gateway, TellsWhoIsThereAsTheServerDoes) {
  ServerConfig config = test::any_port();
  config.web = "0";
  Server server(config, one(test::room(0.0)), test::security({observer().token}));
  Hand hand(server);
  hand.put(0.003);
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway), original(server, std::string(observer().text.text()));
  const auto told = [&](Page& from) {
    Json said;
    test::eventually("the hand's report in the table", [&] {
      said = from.text("sessions")["sessions"];
      return said.size() == 1 && said[0]["wakeups"].is_array() && !said[0]["client"].is_null();
    });
    return said[0];
  };
  hand.be_punctual({3, 0, 2}, {0, 4});
  Json expected = told(original), seen = told(page);
  EXPECT_EQ(seen["wakeups"][2], 2);
  EXPECT_EQ(seen["round_trips"][1], 4);
  EXPECT_EQ(seen["hand_damping"], 1.5);
  EXPECT_LT(std::abs(seen["seconds"].get<double>() - expected["seconds"].get<double>()), 60.0);
  // These values are measured at different moments.
  for (const char* name : {"seconds", "samples_per_s", "loss"}) {
    seen.erase(name);
    expected.erase(name);
  }
  EXPECT_EQ(seen, expected);
}

TEST(Gateway, ShowsTheMaterialsInForce) {
  Server server = server_at();
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway);
  EXPECT_EQ(page.text("hello")["observes"], true);
  EXPECT_EQ(page.text("materials")["objects"][0]["stiffness"], 2000.0);
  test::ControlClient admin(server.control_port());
  admin.ask<control::SceneChanged>(
      control::SetMaterial{"room", {.object = "floor", .stiffness = 500.0}});
  const Json changed = page.text("materials");
  EXPECT_EQ(changed["objects"][0]["stiffness"], 500.0);
  EXPECT_EQ(changed["objects"][1]["stiffness"], 1500.0);
  EXPECT_TRUE(changed["gravity"].is_null());
}

TEST(Gateway, GoesOnWithOthersWhereAViewerDoesNotRead) {
  Server server = server_at();
  Hand hand(server);
  hand.put(0.003);
  const Gateway gateway = gateway_for(server.control_port());
  Page slow = page_of(gateway), page = page_of(gateway);
  EXPECT_EQ(slow.text("hello")["type"], "hello");
  for (int i = 1; i <= 200; ++i) {
    const double z = 1e-4 * i;
    hand.put(z);
    expect_hand(page, z, 0.0);
  }
}

std::string got(const Gateway& gateway, const std::string& path, const std::string& headers = "") {
  test::RawSocket socket(SOCK_STREAM, test::page_port(gateway));
  socket.send(test::bytes("GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1\r\n" + headers + "\r\n"));
  std::string all;
  for (auto more = socket.receive(); !more.empty(); more = socket.receive())
    all.append(more.begin(), more.end());
  return all;
}

TEST(Gateway, StrangersTakeNoPlaceOfAViewer) {
  Server server = server_at();
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway);
  page.text("hello");
  std::vector<std::unique_ptr<test::RawSocket>> silent;
  for (int n = 0; n < 200; ++n)
    silent.push_back(std::make_unique<test::RawSocket>(SOCK_STREAM, test::page_port(gateway)));
  Page pinging(gateway);  // The page connects after all strangers.
  for (int n = 0; n < 3000; ++n) pinging.say_frame(9, "x");
  EXPECT_EQ(pinging.close().reason(), "too many messages");
  page.say({{"ticket", "room"}});
  EXPECT_EQ(page.text("ticket")["type"], "ticket") << "the viewer was thrown out";
}

TEST(Gateway, SaysThatTheServerIsGoneAndFindsItAgain) {
  auto server = std::make_unique<Server>(server_at());
  const std::uint16_t port = server->control_port();
  auto hand = std::make_unique<Hand>(*server);
  hand->put(0.003);
  const Gateway gateway = gateway_for(port);
  Page page = page_of(gateway);
  expect_hand(page, 0.003, 0.0);
  EXPECT_THAT(got(gateway, "/ready"), StartsWith("HTTP/1.1 200 "));
  server.reset();
  const Json gone = page.text("log");
  EXPECT_EQ(gone["level"], "error");
  EXPECT_THAT(gone["text"].get<std::string>(), HasSubstr("the server is shutting down"));
  test::eventually("no hand is shown", [&] {
    const auto picture = page.picture();
    return !picture.empty() && at<std::uint32_t>(picture, 4) == 0;
  });
  const auto shown = [](const IssuedToken& token) {
    return "Authorization: Bearer " + std::string(token.text.text()) + "\r\n";
  };
  EXPECT_THAT(got(gateway, "/ready"),
              ::testing::AllOf(StartsWith("HTTP/1.1 503 "), ::testing::Not(HasSubstr("room"))));
  EXPECT_THAT(got(gateway, "/ready", shown(viewer())), HasSubstr("scene room is not seen"));
  EXPECT_THAT(got(gateway, "/ready", shown(observer())), ::testing::Not(HasSubstr("room")));
  EXPECT_THAT(got(gateway, "/health"), StartsWith("HTTP/1.1 200 "));
  // A viewer that connects meanwhile must get the message too.
  Page other = page_of(gateway);
  EXPECT_THAT(other.text("log")["text"].get<std::string>(), HasSubstr("not seen"));

  server = std::make_unique<Server>(server_at(port));
  hand = std::make_unique<Hand>(*server);
  hand->put(0.004);
  Json back = page.text("log");
  while (back["level"] == "error") back = page.text("log");  // These are messages of the search.
  EXPECT_EQ(back["text"], "Scene room is seen.");
  expect_hand(page, 0.004, 0.0);
  EXPECT_THAT(got(gateway, "/ready"), StartsWith("HTTP/1.1 200 "));
}

TEST(Gateway, BeginsBeforeItsServer) {
  std::uint16_t port = 0;
  { port = server_at().control_port(); }
  const Gateway gateway = gateway_for(port);
  Page page = page_of(gateway);
  EXPECT_EQ(page.text("log")["level"], "error");
  Server server = server_at(port);
  Hand hand(server);
  hand.put(0.003);
  expect_hand(page, 0.003, 0.0);
}

TEST(Gateway, RefusesWhatOnlyTheServerCanDo) {
  Server server = server_at();
  const Gateway gateway = gateway_for(server.control_port());
  Page page = page_of(gateway);
  EXPECT_EQ(page.text("hello")["role"], "admin");
  const std::vector<Json> wanted = {{{"set", {{"object", "floor"}, {"stiffness", 500}}}},
                                    {{"set", {{"gravity", {0, 0, -1}}}}},
                                    {{"evict", "1"}},
                                    {{"reload", true}},
                                    {{"admin", std::string(test::admin_token().text.text())}}};
  for (const Json& wish : wanted) {
    page.say(wish);
    EXPECT_THAT(page.text("refused")["text"].get<std::string>(), HasSubstr("feltwire-client admin"))
        << wish;
  }
  page.say({{"hand", "take"}});  // No hand is offered, but the viewer must stay connected.
  page.say({{"reload", true}});
  EXPECT_EQ(page.text("refused")["type"], "refused");
}

TEST(Gateway, CountsTheServersTimesAsTheServerTellsThem) {
  Server server = server_at();
  Hand hand(server);
  for (int n = 0; n < 3; ++n) hand.put(0.003);
  const Gateway gateway = gateway_for(server.control_port());
  test::eventually("the server's answers, those to the gateway itself among them", [&] {
    const std::string name = "\nfeltwire_answer_seconds_count{scene=\"room\"} ";
    const std::string metrics = got(gateway, "/metrics");
    const std::size_t at = metrics.find(name);
    return at != std::string::npos && std::atoi(metrics.c_str() + at + name.size()) >= 3;
  });
  EXPECT_THAT(got(gateway, "/metrics"),
              HasSubstr("feltwire_world_late_seconds_count{scene=\"room\"} 0\n"));
  server.stop();
  test::eventually("no times of a server that is gone", [&] {
    return got(gateway, "/metrics").find("feltwire_answer_seconds_count") == std::string::npos;
  });
}

TEST(Gateway, HasViewersOfItsOwn) {
  Server server = server_at();
  const Gateway gateway = gateway_for(server.control_port());
  EXPECT_EQ(Page(gateway, std::string(observer().text.text())).close().code(), 4401);
  EXPECT_EQ(Page(gateway, std::string(test::admin_token().text.text())).close().code(), 4401);
  Page page = page_of(gateway);
  page.text("hello");
  page.say({{"ticket", "room"}});
  Page other(gateway, page.text("ticket")["path"].get<std::string>(), "foxglove.sdk.v1");
  EXPECT_EQ(Json::parse(other.next().text())["op"], "serverInfo");
  EXPECT_THAT(got(gateway, "/metrics"), HasSubstr("feltwire_viewers_total 2\n"));
}

/// Returns the error at the start of the gateway.
std::string wrong(std::uint16_t port, Scene scene) {
  try {
    gateway_for(port, std::move(scene));
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(Gateway, NamesWhatIsWrongWithItsScene) {
  Server server = server_at();
  Scene other("cellar", test::room().objects());
  EXPECT_THAT(wrong(server.control_port(), other),
              ::testing::AllOf(StartsWith("--scene: "), HasSubstr("no scene 'cellar'"),
                               HasSubstr("it has: room")));
  Scene smaller("room", {test::room().objects()[1]});
  EXPECT_THAT(wrong(server.control_port(), smaller),
              ::testing::AllOf(StartsWith("--scene: "), HasSubstr("has 2 objects"),
                               HasSubstr("the file has 1")));
}

TEST(Gateway, EndsWhereTheServerDoesNotLetItIn) {
  Server server = server_at();
  GatewayConfig config = config_for(server.control_port());
  config.server.credentials.token = issue_token("nobody", "*", Role::observer, std::nullopt).text;
  EXPECT_THROW(Gateway(config, one(test::room(0.0)), test::security()), LastingError);
}

TEST(GatewayProgram, SaysInOneLineWhatIsMissing) {
  const auto said = [](std::vector<std::string> arguments) {
    test::Program program(FELTWIRE_VIEW_PROGRAM, std::move(arguments));
    return program.finish();
  };
  const test::Outcome none = said({"--connect", "localhost:1"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.error, ::testing::AllOf(StartsWith("feltwire-view: "), HasSubstr("--scene")));
  const test::Outcome no_file =
      said({"--connect", "localhost:1", "--scene", "nowhere.json", "--fingerprint",
            std::string(64, 'a'), "--token-file", "/proc/nowhere"});
  EXPECT_EQ(no_file.status, 2);
  EXPECT_THAT(no_file.error, HasSubstr("/proc/nowhere"));
  const test::Outcome no_name = said(
      {"--connect", "localhost:1", "--scene", "nowhere.json", "--web-name", "https://lab.example"});
  EXPECT_EQ(no_name.status, 2);
  EXPECT_THAT(no_name.error, HasSubstr("--web-name: 'https://lab.example'"));
}

TEST(GatewayProgram, ReadsOptionsFromAFile) {
  const test::TemporaryFolder folder;
  const std::string file = folder / "view.json";
  const auto refused = [&](const std::string& json, std::vector<std::string> words = {}) {
    std::ofstream(file) << json;
    words.insert(words.begin(), {"--config", file});
    const test::Outcome outcome = test::Program(FELTWIRE_VIEW_PROGRAM, words).finish();
    EXPECT_EQ(outcome.status, 2) << outcome.error;
    return outcome.error;
  };
  const std::string said =
      "\"connect\": \"localhost:1\",\n\"fingerprint\": \"" + std::string(64, 'a') + "\"";
  // The files of the configuration lie in its folder.
  EXPECT_THAT(refused("{" + said + ", \"scenes\": [\"a.json\"], \"token_file\": \"none\"}"),
              HasSubstr((folder / "none").string()));
  EXPECT_THAT(refused("{" + said + ",\n\"scenes\": [\"a.json\"], \"web_names\": [\"a b\"]}"),
              HasSubstr(file + ":3: web_names: 'a b'"));
  EXPECT_THAT(refused("{\n\"scene\": \"a.json\"}"),
              HasSubstr(file + ":2: scene: is no option of this program; did you mean scenes?"));
  EXPECT_THAT(refused("{\n\"log_level\": \"loud\"}"), HasSubstr(file + ":2: log_level: "));
  // The command line overrides the file.
  EXPECT_THAT(refused("{" + said + ", \"scenes\": [\"a.json\"], \"token_file\": \"none\"}",
                      {"--token-file", "/proc/nowhere"}),
              HasSubstr("/proc/nowhere"));
  EXPECT_THAT(refused("{" + said + ", \"scenes\": [\"a.json\"]}", {"fw_0123456789ab_secret"}),
              ::testing::AllOf(HasSubstr("fw_..."), ::testing::Not(HasSubstr("0123456789ab"))));
}

/// A page at the address that a program printed.
struct PrintedSite {
  std::string url;
  std::string web_url() const { return url; }
};

TEST(GatewayProgram, ReadsItsScenesAnewWhereItIsTold) {
  const test::TemporaryFolder folder;
  const auto scene = folder / "room.json", state = folder / "state", token = folder / "token";
  std::ofstream(token) << observer().text.text();
  std::filesystem::permissions(token, std::filesystem::perms::owner_read);
  const auto write = [&](const std::string& object) {
    std::ofstream(scene) << R"({"name": "room", "materials": [{"name": "m", "stiffness": 500}],)"
                         << "\n"
                         << R"("objects": [)" << object << "]}";
  };
  write(R"({"name": "floor", "plane": {}, "material": "m"})");
  const std::uint16_t nobody = [] { return server_at().control_port(); }();
  test::Program program(
      FELTWIRE_VIEW_PROGRAM,
      {"--connect", "127.0.0.1:" + std::to_string(nobody), "--scene", scene, "--web", "0",
       "--state", state, "--fingerprint", std::string(64, 'a'), "--token-file", token});
  const std::string said = program.line(), before = "live page: http://127.0.0.1:";
  ASSERT_THAT(said, StartsWith(before));
  PrintedSite site{said.substr(before.size() - std::string("http://127.0.0.1:").size())};
  site.url.erase(site.url.find_last_not_of('/') + 1);
  Page page(site, test::text_of(state / "local.token"));
  EXPECT_EQ(page.text("scene")["objects"][0]["name"], "floor");

  write(
      R"({"name": "wall", "plane": {}, "material": "m"}, {"name": "ball", "sphere": {"radius": 0.01}, "material": "m"})");
  program.signal(SIGHUP);
  Json anew = page.text("scene");
  EXPECT_EQ(anew["objects"].size(), 2u);
  EXPECT_EQ(anew["objects"][0]["name"], "wall");

  write(R"({"name": "wall", "plane": {}, "material": "m", "colour": 3})");
  program.signal(SIGHUP);
  EXPECT_THAT(program.error_until("the scene stays as it was"),
              ::testing::AllOf(HasSubstr("room.json:2"), HasSubstr("colour")));
  write(R"({"name": "floor", "plane": {}, "material": "m"})");
  program.signal(SIGHUP);
  anew = page.text("scene");
  EXPECT_EQ(anew["objects"].size(), 1u);
  EXPECT_EQ(anew["objects"][0]["name"], "floor");
  program.signal(SIGTERM);
  EXPECT_EQ(program.finish().status, 0);
}

}  // namespace
}  // namespace feltwire::gateway_test
