// Tests the live page of a complete server over real sockets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "server/app/server.hpp"
#include "server/web/web_server.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/web/page_client.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::live_page_test {
namespace {

using test::bytes;
using test::Page;
using test::page_port;
using test::with_page;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;

/// Returns all data until the other side closes.
std::string rest(test::RawSocket& socket) {
  std::string all;
  for (auto more = socket.receive(); !more.empty(); more = socket.receive())
    all.append(more.begin(), more.end());
  return all;
}

std::string good_token() { return std::string(test::admin_token().text.text()); }

template <class Value>
Value at(const std::vector<std::uint8_t>& bytes, std::size_t place) {
  Value value{};
  EXPECT_LE(place + sizeof value, bytes.size());
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

TEST(LivePage, IsOffUnlessAsked) {
  const Server server(test::any_port(), {test::room()}, test::security());
  EXPECT_EQ(server.web_url(), "");
}

TEST(LivePage, ShowsAHandThatPresses) {
  Server server(with_page(), {test::room(0.0)}, test::security());
  test::ControlClient control(server.control_port());
  const test::JoinedBy joined = control.join(test::join_request(SessionParameters{}));
  test::RawSocket hand(SOCK_DGRAM, joined.udp_port);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  std::uint64_t packet = 0;
  const auto press = [&](double z) {
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = test::hand(++packet);
    batch.samples[0].pose.position = {-0.05, 0, z};
    batch.previous = packet - 1;
    hand.send(encoder.samples(joined.accepted.session, packet, batch));
    ASSERT_FALSE(hand.receive().empty());
  };
  press(0.001);

  Page page(server, good_token());
  EXPECT_THAT(page.head(), StartsWith("HTTP/1.1 101 "));
  EXPECT_EQ(page.text("hello")["scenes"], Json({"room"}));
  EXPECT_EQ(page.text("scene")["objects"][1]["name"], "ball");
  const test::Frame ball = page.next();
  ASSERT_EQ(ball.opcode, 2);
  EXPECT_EQ(at<std::uint8_t>(ball.payload, 0), 1);

  const auto seen_at = [&](float z) {
    test::eventually("a picture of the hand at " + std::to_string(z), [&] {
      const auto picture = page.picture();
      return at<std::uint32_t>(picture, 4) == 1 && at<float>(picture, 24 + 16) == z;
    });
  };
  seen_at(0.001f);
  press(-0.002);
  test::eventually("a picture with force", [&] {
    const auto picture = page.picture();
    constexpr std::size_t kHand = 24, kElasticZ = kHand + 8 + 4 * (3 + 4 + 3 + 2);
    return std::abs(at<float>(picture, kElasticZ) - 4.0f) < 1e-4f;  // 2000 N/m at this depth
  });
  test::eventually("the sessions' table", [&] {
    const Json said = page.text("sessions");
    return said["sessions"].size() == 1 && said["sessions"][0]["client"] == "tester";
  });
}

TEST(LivePage, RefusesAWrongToken) {
  Server server(with_page(), {test::room()}, test::security());
  const test::Frame wrong = Page(server, "fw_123456789012_wrong").close();
  EXPECT_EQ(wrong.code(), 4401);
  EXPECT_THAT(wrong.reason(), HasSubstr("token"));
  Page silent(server);
  silent.say({{"watch", "room"}});
  EXPECT_EQ(silent.close().code(), 4401);
  // The server must delay a viewer with wrong tokens.
  int slowed = 0;
  for (int i = 0; i < 12; ++i)
    if (Page(server, "fw_123456789012_wrong").close().code() == 4429) ++slowed;
  EXPECT_GE(slowed, 1);
  // The server must not delay a viewer with a valid token.
  EXPECT_EQ(Page(server, good_token()).text("hello")["role"], "admin");
}

TEST(LivePage, WrongTokensForATicketAreLimited) {
  Server server(with_page(), {test::room()}, test::security());
  const auto ask = [&](std::string_view token) {
    test::RawSocket asked(SOCK_STREAM, page_port(server));
    asked.send(
        bytes("GET /ticket?scene=room HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer " +
              std::string(token) + "\r\n\r\n"));
    return rest(asked);
  };
  int limited = 0;
  for (int i = 0; i < 12; ++i) limited += ask("fw_123456789012_wrong").starts_with("HTTP/1.1 429 ");
  EXPECT_GE(limited, 1);
  EXPECT_THAT(ask(good_token()), StartsWith("HTTP/1.1 200 "));
}

TEST(LivePage, ShowsOnlyWhatTheTokenOpens) {
  const IssuedToken narrow = issue_token("eye", "ball", Role::observer, std::nullopt);
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  scenes.push_back(Scene("ball", {test::room().objects()[1]}));
  Server server(with_page(), std::move(scenes), test::security({narrow.token}));
  Page page(server, std::string(narrow.text.text()));
  EXPECT_EQ(page.text("hello")["scenes"], Json({"ball"}));
  EXPECT_EQ(page.text("scene")["name"], "ball");
  page.say({{"watch", "room"}});
  EXPECT_EQ(page.close().code(), 4400);

  Page all(server, good_token());
  EXPECT_EQ(all.text("scene")["name"], "room");
  all.say({{"watch", "ball"}});
  EXPECT_EQ(all.text("scene")["name"], "ball");
}

TEST(LivePage, AnswersRequests) {
  Server server(with_page(), {test::room()}, test::security());
  test::RawSocket health(SOCK_STREAM, page_port(server));
  health.send(bytes("GET /health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
  EXPECT_THAT(rest(health), StartsWith("HTTP/1.1 200 "));
  test::RawSocket garbage(SOCK_STREAM, page_port(server));
  garbage.send(bytes("\x16\x03\x01 hello\r\n\r\n"));
  EXPECT_THAT(rest(garbage), StartsWith("HTTP/1.1 400 "));
  test::RawSocket long_head(SOCK_STREAM, page_port(server));
  long_head.send(bytes("GET / HTTP/1.1\r\nA: " + std::string(9000, 'a')));
  EXPECT_THAT(rest(long_head), StartsWith("HTTP/1.1 400 "));
}

TEST(LivePage, CountsForPrometheus) {
  Server server(with_page(), {test::room()}, test::security());
  test::ControlClient control(server.control_port());
  control.join(test::join_request());
  test::RawSocket asked(SOCK_STREAM, page_port(server));
  asked.send(bytes("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
  const std::string said = rest(asked);
  EXPECT_THAT(said,
              HasSubstr("# TYPE feltwire_sessions gauge\nfeltwire_sessions{scene=\"room\"} 1\n"));
  EXPECT_THAT(said, HasSubstr("feltwire_sessions_ended_total{scene=\"room\",how=\"flooded\"} 0\n"));
  EXPECT_THAT(said,
              HasSubstr("feltwire_datagrams_dropped_total{scene=\"room\",reason=\"sealed\"} 0\n"));
  EXPECT_THAT(said, HasSubstr("\nfeltwire_control_connections_total 1\n"));
  EXPECT_THAT(said, HasSubstr("# TYPE feltwire_answer_seconds histogram\n"
                              "feltwire_answer_seconds_bucket{scene=\"room\",le=\"1e-05\"} "));
}

TEST(LivePage, LetsAnotherProgramLookOnWithATicket) {
  Server server(with_page(), {test::room()}, test::security());
  Page page(server, good_token());
  page.text("hello");
  page.say({{"ticket", "room"}});
  const Json ticket = page.text("ticket");
  EXPECT_EQ(ticket["seconds"], 60);
  const std::string path = ticket["path"];
  Page other(server, path, "foxglove.websocket.v1");
  EXPECT_THAT(other.head(), StartsWith("HTTP/1.1 101 "));
  EXPECT_EQ(Json::parse(other.next().text())["op"], "serverInfo");
  EXPECT_EQ(Json::parse(other.next().text())["op"], "advertise");
  other.say({{"op", "subscribe"}, {"subscriptions", Json::array({{{"id", 3}, {"channelId", 0}}})}});
  const test::Frame geometry = other.next();
  EXPECT_EQ(geometry.opcode, 2);
  EXPECT_EQ(at<std::uint32_t>(geometry.payload, 1), 3u);
  EXPECT_THAT(Page(server, path, "foxglove.websocket.v1").head(), StartsWith("HTTP/1.1 403 "));
  // The server must ignore messages that a viewer publishes.
  other.say({{"op", "advertise"}});
  EXPECT_EQ(Json::parse(other.next().text())["op"], "status");
  page.say({{"ticket", "cellar"}});
  EXPECT_EQ(page.close().code(), 4400);
}

TEST(LivePage, EndsWhoDoesNotSpeakItsProtocol) {
  Server server(with_page(), {test::room()}, test::security());
  Page page(server, good_token());
  page.text("hello");
  page.say(Json::array());
  EXPECT_EQ(page.close().code(), 4400);
}

TEST(LivePage, SaysThatTheServerEnds) {
  auto server =
      std::make_unique<Server>(with_page(), std::vector<Scene>{test::room()}, test::security());
  Page page(*server, good_token());
  page.text("hello");
  server.reset();
  EXPECT_EQ(page.close().code(), 1001);
}

/// Page and WebSocket must use TLS beyond this machine. Without TLS they must not answer.
TEST(LivePage, IsEncryptedBeyondThisMachine) {
  ServerConfig config = with_page();
  config.web = "0.0.0.0:0";
  Server server(config, {test::room()}, test::security());
  EXPECT_THAT(server.web_url(), StartsWith("https://"));
  const std::string host = "127.0.0.1:" + std::to_string(page_port(server));
  const test::TlsContext context = test::client_context();
  test::RawSocket socket(SOCK_STREAM, page_port(server)), other(SOCK_STREAM, page_port(server)),
      plain(SOCK_STREAM, page_port(server));
  test::TlsConnection page(context.get(), socket.descriptor());
  ASSERT_TRUE(page.connect());
  page.write(bytes("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n"));
  const auto answer = page.read(1000);
  EXPECT_THAT(
      std::string(answer.begin(), answer.end()),
      ::testing::AllOf(StartsWith("HTTP/1.1 200 "), HasSubstr("Content-Security-Policy: ")));

  test::TlsConnection live(context.get(), other.descriptor());
  ASSERT_TRUE(live.connect());
  live.write(bytes("GET /live HTTP/1.1\r\nHost: " + host + "\r\nOrigin: https://" + host +
                   "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13"
                   "\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                   "Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n"));
  std::vector<std::uint8_t> came;
  const auto more = [&] {
    const auto byte = live.read(1);
    came.insert(came.end(), byte.begin(), byte.end());
    return !byte.empty();
  };
  while (!std::string(came.begin(), came.end()).ends_with("\r\n\r\n")) ASSERT_TRUE(more());
  EXPECT_THAT(std::string(came.begin(), came.end()), StartsWith("HTTP/1.1 101 "));
  came.clear();
  live.write(test::client_frame(1, Json{{"token", good_token()}}.dump()));
  std::optional<test::Frame> first;
  while (!(first = test::take_frame(came))) ASSERT_TRUE(more());
  EXPECT_EQ(Json::parse(first->text())["type"], "hello");

  plain.send(bytes("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n"));
  EXPECT_THAT(rest(plain), ::testing::Not(HasSubstr("HTTP")));
}

/// Viewers that stay connected.
class Crowd {
 public:
  explicit Crowd(const Server& server) : server_(server) {}
  void enter(const std::string& token, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) {
      viewers_.push_back(std::make_unique<Page>(server_, token));
      ASSERT_EQ(viewers_.back()->text("hello")["type"], "hello") << viewers_.size();
    }
  }
  void expect_refused(const std::string& token, const std::string& why) {
    const test::Frame refused = Page(server_, token).next();
    EXPECT_EQ(refused.code(), 4429);
    EXPECT_THAT(refused.reason(), HasSubstr(why));
  }
  void leave_one() { viewers_.pop_back(); }

 private:
  const Server& server_;
  std::vector<std::unique_ptr<Page>> viewers_;
};

IssuedToken observer(const std::string& client) {
  return issue_token(client, "*", Role::observer, std::nullopt);
}
std::string text_of(const IssuedToken& token) { return std::string(token.text.text()); }

/// Observers of five clients take all their slots. The slots of admins must stay free.
TEST(LivePage, HasPlacesForSoManyViewersAndForAdmins) {
  using web::ViewerHub;
  std::vector<IssuedToken> observers;
  Tokens tokens;
  for (const char* name : {"a", "b", "c", "d", "e"})
    tokens.push_back(observers.emplace_back(observer(name)).token);
  Server server(with_page(), {test::room()}, test::security(tokens));
  Crowd crowd(server);
  std::size_t left = ViewerHub::kMostViewers - ViewerHub::kPlacesForAdmins;
  for (const IssuedToken& token : observers) {
    const std::size_t some = std::min(left, ViewerHub::kMostViewersOfClient);
    crowd.enter(text_of(token), some);
    left -= some;
  }
  ASSERT_EQ(left, 0u);
  crowd.expect_refused(text_of(observers.back()), "keeps its last places for admins");
  crowd.enter(good_token(), ViewerHub::kPlacesForAdmins);
  crowd.expect_refused(good_token(), "as many viewers as it may have; close another page");
  crowd.leave_one();
  test::eventually("a free place",
                   [&] { return Page(server, good_token()).text("hello")["type"] == "hello"; });
}

/// All tokens of a client name must count together, including the tickets of this name.
TEST(LivePage, OneClientDoesNotTakeEveryPlace) {
  const IssuedToken one = observer("eye"), same = observer("eye"), other = observer("ear");
  Server server(with_page(), {test::room()}, test::security({one.token, same.token, other.token}));
  Page first(server, text_of(one));
  first.text("hello");
  first.say({{"ticket", "room"}});
  const std::string path = first.text("ticket")["path"];
  Crowd crowd(server);
  crowd.enter(text_of(one), 4);
  crowd.enter(text_of(same), web::ViewerHub::kMostViewersOfClient - 5);
  crowd.expect_refused(text_of(one), "this client's name has all its 8 viewers");
  crowd.expect_refused(text_of(same), "this client's name has all its 8 viewers");
  EXPECT_EQ(Page(server, path, "foxglove.sdk.v1").next().code(), 4429);
  crowd.enter(text_of(other), web::ViewerHub::kMostViewersOfClient);
}

/// Strangers must displace only strangers.
TEST(LivePage, StrangersTakeNoPlaceOfAViewer) {
  Server server(with_page(), {test::room()}, test::security());
  Page viewer(server, good_token());
  viewer.text("hello");
  std::vector<std::unique_ptr<test::RawSocket>> silent;
  for (int n = 0; n < 200; ++n)
    silent.push_back(std::make_unique<test::RawSocket>(SOCK_STREAM, page_port(server)));
  // An answer to a new connection shows that the server accepted the earlier connections.
  test::RawSocket newcomer(SOCK_STREAM, page_port(server));
  newcomer.send(bytes("GET /health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
  EXPECT_THAT(rest(newcomer), StartsWith("HTTP/1.1 200 "));
  viewer.say({{"ticket", "room"}});
  EXPECT_EQ(viewer.text("ticket")["type"], "ticket") << "the viewer was thrown out";
  EXPECT_EQ(Page(server, good_token()).text("hello")["type"], "hello");
}

TEST(LivePage, EndsAStrangerThatOnlyPings) {
  Server server(with_page(), {test::room()}, test::security());
  Page page(server);
  for (int n = 0; n < 3000; ++n) page.say_frame(9, "x");
  std::size_t answers = 0;
  test::Frame frame = page.next();
  for (; frame.opcode == 10; frame = page.next()) ++answers;
  EXPECT_EQ(frame.code(), 4400);
  EXPECT_EQ(frame.reason(), "too many messages");
  EXPECT_LT(answers, 1000u);
}

TEST(LivePage, EndsAViewerThatSaysTooMuch) {
  Server server(with_page(), {test::room()}, test::security());
  Page page(server, good_token());
  page.text("hello");
  for (int n = 0; n < 60; ++n) page.say({{"watch", "room"}});
  const test::Frame ended = page.close();
  EXPECT_EQ(ended.code(), 4400);
  EXPECT_EQ(ended.reason(), "too many messages");
}

/// In a full network, the newest connection must take the slot of the oldest. Other networks must
/// keep their slots.
TEST(LivePage, ANetworkTakesPlacesFromItself) {
  web::WebOptions options;
  options.address = asio::ip::make_address("127.0.0.1");
  options.patience = std::chrono::minutes(10);
  options.max_connections_per_network = 2;
  const Security security = test::security();
  web::WebServer server(options, {}, security.tokens, security.identity);
  server.start();
  const auto closed = [](const test::RawSocket& socket) {
    pollfd waiting{socket.descriptor(), POLLIN, 0};
    char byte = 0;
    return ::poll(&waiting, 1, test::kPatience) == 1 &&
           ::recv(socket.descriptor(), &byte, 1, 0) == 0;
  };
  const auto answers = [](test::RawSocket& socket) {
    socket.send(bytes("GET /health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
    return rest(socket).starts_with("HTTP/1.1 200 ");
  };
  test::RawSocket first(SOCK_STREAM, server.port()), second(SOCK_STREAM, server.port()),
      elsewhere(SOCK_STREAM, server.port(), AF_INET, "127.0.1.1"),
      third(SOCK_STREAM, server.port());
  EXPECT_TRUE(closed(first));
  EXPECT_TRUE(answers(second));
  EXPECT_TRUE(answers(elsewhere));
  EXPECT_TRUE(answers(third));
}

TEST(LivePage, ManyComeAndGo) {
  Server server(with_page(), {test::room()}, test::security());
  for (int i = 0; i < 200; ++i) Page(server, good_token()).text("hello");
  EXPECT_EQ(Page(server, good_token()).text("hello")["type"], "hello");
}

}  // namespace
}  // namespace feltwire::live_page_test
