// Tests a connection to the live page byte by byte. A peer that sends and does not read must need
// limited memory.

#include "server/web/connection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "tests/client/temporary_folder.hpp"
#include "tests/server/web/frames.hpp"
#include "tests/support/security.hpp"

namespace feltwire::web::connection_test {
namespace {

using test::client_frame;
using ::testing::StartsWith;

/// The other end of a connection. This end takes written data only on request.
struct OtherEnd {
  std::vector<Output> written;
  Stream::Done taken;  // empty: no write in progress
  Stream::Read read;   // empty: no read in progress
  bool closed = false;

  /// Takes the current write. The next write then starts.
  void take() { std::exchange(taken, {})({}); }
  void take_all() {
    while (taken) take();
  }
  void say(std::span<const std::uint8_t> bytes) { std::exchange(read, {})({}, bytes); }
  void say(std::string_view text) {
    say({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  std::string text() const {
    std::string all;
    for (const Output& output : written) {
      all.append(output.own.begin(), output.own.end());
      all.append(output.shared.text());
    }
    return all;
  }
  /// Returns the WebSocket frames after the answer to the request.
  std::vector<test::Frame> frames() const {
    const std::string all = text();
    const std::size_t begin = all.find("\r\n\r\n") + 4;
    std::vector<std::uint8_t> bytes(all.begin() + static_cast<std::ptrdiff_t>(begin), all.end());
    std::vector<test::Frame> found;
    while (const auto frame = test::take_frame(bytes)) found.push_back(*frame);
    return found;
  }
};

class FakeStream : public Stream {
 public:
  explicit FakeStream(OtherEnd& end) : end_(end) {}
  void handshake(Done done) override { done({}); }
  void read(Read done) override {
    EXPECT_FALSE(end_.read) << "two reads at a time";
    end_.read = std::move(done);
  }
  void write(Output output, Done done) override {
    EXPECT_FALSE(end_.taken) << "two writes at a time";
    end_.written.push_back(std::move(output));
    end_.taken = std::move(done);
  }
  void end_writing() override {}
  void close() noexcept override { end_.closed = true; }

 private:
  OtherEnd& end_;
};

constexpr std::array<unsigned char, 5> kFile = {'a', 'b', 'c', 'd', 'e'};
const std::array<PageAsset, 1> kPage = {{{"/", "text/html", "1234", kFile}}};
const std::string kUpgrade =
    "GET /live HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://127.0.0.1\r\nConnection: Upgrade\r\n"
    "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n";

class ConnectionTest : public ::testing::Test, public ConnectionHost {
 public:
  asio::io_context& io() override { return io_; }
  ViewerHub& hub() override { return hub_; }
  std::string_view log_name() const override { return "metrics"; }
  Site site(const asio::ip::address&) override {
    Site site{kPage, {}, false};
    site.metrics = []() -> std::string { throw std::runtime_error("no counters"); };
    if (!recording_.empty())
      site.redeem_download = [this](std::string_view) { return std::optional(recording_); };
    return site;
  }
  std::chrono::milliseconds patience() const override { return std::chrono::minutes(10); }
  void admitted(ConnectionSlots::Id) override { ++admitted_; }
  void parting(ConnectionSlots::Id) override { ++parting_; }
  void ended(ConnectionSlots::Id) noexcept override { ++ended_; }

 protected:
  ConnectionTest() { connection_->start(); }
  ~ConnectionTest() override {
    connection_->end();
    other_.taken = {};
    other_.read = {};
  }

  /// Opens a WebSocket without a token.
  void upgrade() {
    other_.say(kUpgrade);
    ASSERT_THAT(other_.text(), StartsWith("HTTP/1.1 101 "));
    other_.take();
    ASSERT_TRUE(other_.read);
  }
  /// Opens a WebSocket with a valid token.
  void enter() {
    upgrade();
    connection_->admitted();
  }
  /// Returns true if the connection has ended after the pending handlers.
  bool over() {
    io_.poll();
    io_.restart();
    return other_.closed;
  }

  asio::io_context io_;
  ViewerHub hub_{io_, {}, test::security().tokens};
  OtherEnd other_;
  std::shared_ptr<Connection> connection_ = std::make_shared<Connection>(
      *this, 1, std::make_unique<FakeStream>(other_), asio::ip::make_address("127.0.0.1"));
  int admitted_ = 0, parting_ = 0, ended_ = 0;
  std::filesystem::path recording_;  // empty: there is none
};

constexpr std::size_t kLong = std::size_t{10} * 64 * 1024 + 7;  // [bytes]
const std::string kDownload = "GET /recording?ticket=fw_t HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";

TEST_F(ConnectionTest, ALongFileWaitsForASlowClient) {
  const testing::TemporaryFolder folder;
  std::string file(kLong, 'x');
  for (std::size_t i = 0; i < file.size(); ++i) file[i] = static_cast<char>('a' + i / 1000 % 26);
  recording_ = folder / "recording.mcap";
  std::ofstream(recording_, std::ios::binary) << file;
  other_.say(kDownload);
  EXPECT_EQ(admitted_, 1);  // Strangers cannot take its place.
  ASSERT_EQ(other_.written.size(), 1u);
  other_.take();
  for (std::size_t pieces = 2; other_.taken; ++pieces) {
    // The next piece is read only after the client has taken this one.
    ASSERT_EQ(other_.written.size(), pieces);
    EXPECT_LE(other_.written.back().own.size(), SentFile::kPiece);
    other_.take();
  }
  const std::string text = other_.text();
  EXPECT_EQ(text.substr(text.find("\r\n\r\n") + 4), file);
  EXPECT_EQ(parting_, 1);
}

/// The client sees that the file is cut, because the answer states its length.
TEST_F(ConnectionTest, AFileThatBecomesShorterEndsTheConnection) {
  const testing::TemporaryFolder folder;
  recording_ = folder / "recording.mcap";
  std::ofstream(recording_, std::ios::binary) << std::string(kLong, 'x');
  other_.say(kDownload);
  other_.take();
  std::filesystem::resize_file(recording_, 10);
  other_.take_all();
  EXPECT_TRUE(over());
  EXPECT_LT(other_.text().size(), kLong);
}

TEST_F(ConnectionTest, AFailureNamesThePort) {
  std::ostringstream log;
  const auto usual = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  other_.say("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  spdlog::set_default_logger(usual);
  EXPECT_THAT(log.str(), ::testing::HasSubstr("metrics: a connection from 127.0.0.1 ends"));
  EXPECT_TRUE(over());
}

TEST_F(ConnectionTest, ReadsNothingWhileOutputWaits) {
  enter();
  other_.say(client_frame(9, "one"));
  ASSERT_TRUE(other_.taken);
  EXPECT_FALSE(other_.read) << "its answer is not taken yet";
  connection_->send("news");
  other_.take();
  EXPECT_FALSE(other_.read) << "the news is not taken yet";
  other_.take();
  EXPECT_TRUE(other_.read);
  EXPECT_EQ(other_.frames().size(), 2u);
}

/// Frames that need no answer must count too.
TEST_F(ConnectionTest, EveryFrameCountsAsAMessage) {
  for (const auto& [opcode, last] : {std::pair(9, true), {10, true}, {0, false}}) {
    upgrade();
    std::vector<std::uint8_t> flood = client_frame(1, "", false);
    if (opcode != 0) flood.clear();
    while (flood.size() < 3000) {
      const auto frame = client_frame(opcode, "", last);
      flood.insert(flood.end(), frame.begin(), frame.end());
    }
    other_.say(flood);
    other_.take_all();
    const std::vector<test::Frame> answers = other_.frames();
    ASSERT_FALSE(answers.empty()) << opcode;
    EXPECT_EQ(answers.back().code(), 4400) << opcode;
    EXPECT_EQ(answers.back().reason(), "too many messages");
    // The limit is 40 at once and 20 a second during the test.
    EXPECT_LT(answers.size(), 200u) << opcode;
    EXPECT_EQ(parting_, 1);
    connection_->end();
    other_ = {};
    parting_ = 0;
    connection_ = std::make_shared<Connection>(*this, 2, std::make_unique<FakeStream>(other_),
                                               asio::ip::make_address("127.0.0.1"));
    connection_->start();
  }
}

TEST_F(ConnectionTest, EndsAViewerThatLetsTooMuchWait) {
  enter();
  connection_->send("first");  // This write never completes.
  const std::string news(1000, 'n');
  std::size_t sent = 0;
  for (; sent + 2 * news.size() < Viewer::kMostWaiting; sent += news.size())
    connection_->send(news);
  EXPECT_FALSE(over());
  EXPECT_FALSE(connection_->ready());
  for (int i = 0; i < 1000; ++i) connection_->send(news);
  EXPECT_EQ(ended_, 0) << "not while the hub may go through its viewers";
  EXPECT_TRUE(over());
  EXPECT_EQ(ended_, 1);
}

TEST_F(ConnectionTest, TheSceneMayBeLargeAndIsNotCopied) {
  enter();
  const SharedBytes object(std::vector<std::uint8_t>(1'000'000, 7));
  EXPECT_TRUE(connection_->ready());
  connection_->show_text(SharedBytes(std::string("scene")));
  for (int i = 0; i < 5; ++i) static_cast<Viewer&>(*connection_).show_binary(object);
  connection_->send("news");
  EXPECT_FALSE(over());
  EXPECT_FALSE(connection_->ready());
  other_.take_all();
  std::size_t own = 0, shared = 0;
  for (const Output& output : other_.written) {
    own += output.own.size();
    if (output.shared.empty()) continue;
    ++shared;
    EXPECT_EQ(output.shared.bytes().data(), object.bytes().data());
  }
  EXPECT_EQ(shared, 5u);
  EXPECT_LT(own, 1000u);
  EXPECT_TRUE(connection_->ready());
}

TEST_F(ConnectionTest, AFileOfThePageIsNotCopied) {
  other_.say("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  ASSERT_EQ(other_.written.size(), 1u);
  EXPECT_EQ(other_.written[0].shared.bytes().data(), kFile.data());
  EXPECT_FALSE(other_.read) << "a second request is not read before the first is answered";
}

/// The server discards bytes after a request, so that its answer arrives. The server must not
/// discard bytes forever.
TEST_F(ConnectionTest, AnEndlessRequestEnds) {
  other_.say("POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 999999999\r\n\r\n");
  EXPECT_THAT(other_.text(), StartsWith("HTTP/1.1 400 "));
  other_.take();
  const std::string body(4096, 'b');
  std::size_t read = 0;
  for (; !other_.closed && read < 10'000'000; read += body.size()) other_.say(body);
  EXPECT_TRUE(other_.closed);
  EXPECT_LE(read, Connection::kMostDiscarded + body.size());
}

TEST_F(ConnectionTest, AViewerThatGoesOnAfterItsCloseEnds) {
  enter();
  connection_->close(WebSocketClose::bad_message, "enough");
  EXPECT_EQ(parting_, 1);
  EXPECT_FALSE(connection_->ready());
  other_.take_all();
  const std::vector<std::uint8_t> more = client_frame(1, std::string(4000, 'm'));
  std::size_t read = 0;
  for (; !other_.closed && read < 10'000'000; read += more.size()) other_.say(more);
  EXPECT_TRUE(other_.closed);
  EXPECT_LE(read, Connection::kMostDiscarded + more.size());
}

/// A viewer that breaks the WebSocket rules must lose its slot and its role.
TEST_F(ConnectionTest, ABrokenRuleTakesTheSeat) {
  enter();
  EXPECT_FALSE(hub_.empty());
  const std::vector<std::uint8_t> unmasked = {0x81, 0x01, 'x'};
  other_.say(unmasked);
  EXPECT_TRUE(hub_.empty());
  EXPECT_EQ(parting_, 1);
  EXPECT_FALSE(connection_->ready());
  other_.take_all();
  EXPECT_EQ(other_.frames().back().code(), 1002);
}

}  // namespace
}  // namespace feltwire::web::connection_test
