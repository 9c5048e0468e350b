// One end of a WebSocket by its bytes: messages whole and in pieces, and what is no WebSocket's.

#include "server/web/websocket.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/server/web/frames.hpp"

namespace feltwire::websocket_test {
namespace {

using test::client_frame;

struct End {
  explicit End(std::size_t most = 1000)
      : socket(most, [this](std::string_view message) { said.emplace_back(message); }) {}

  /// All frames that it has to send.
  std::vector<test::Frame> sent() {
    std::vector<std::uint8_t> bytes = socket.take_output();
    std::vector<test::Frame> frames;
    while (const auto frame = test::take_frame(bytes)) frames.push_back(*frame);
    EXPECT_TRUE(bytes.empty());
    return frames;
  }

  std::vector<std::string> said;
  WebSocket socket;
};

TEST(WebSocket, TakesMessagesWholeAndInPieces) {
  End end;
  EXPECT_TRUE(end.socket.receive(client_frame(1, "one")));
  std::vector<std::uint8_t> bytes = client_frame(1, std::string(300, 'x'));
  for (const std::uint8_t byte : bytes) EXPECT_TRUE(end.socket.receive({&byte, 1}));
  end.socket.receive(client_frame(1, "th", false));
  end.socket.receive(client_frame(0, "ree"));
  EXPECT_EQ(end.said, (std::vector<std::string>{"one", std::string(300, 'x'), "three"}));
  EXPECT_FALSE(end.socket.has_output());
}

TEST(WebSocket, SendsTextAndBytes) {
  End end;
  end.socket.send_text("hello");
  const std::vector<std::uint8_t> large(70'000, 7);
  end.socket.send_binary(large);
  EXPECT_TRUE(end.socket.has_output());
  const auto frames = end.sent();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].opcode, 1);
  EXPECT_EQ(frames[0].text(), "hello");
  EXPECT_EQ(frames[1].opcode, 2);
  EXPECT_EQ(frames[1].payload, large);
  EXPECT_FALSE(end.socket.has_output());
}

TEST(WebSocket, AnswersAPing) {
  End end;
  end.socket.receive(client_frame(9, "there?"));
  const auto frames = end.sent();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].opcode, 10);
  EXPECT_EQ(frames[0].text(), "there?");
}

TEST(WebSocket, ClosesWithItsReason) {
  End end;
  end.socket.close(WebSocketClose::bad_token, std::string(500, 'r'));
  end.socket.send_text("never sent");
  const auto frames = end.sent();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].opcode, 8);
  EXPECT_EQ(frames[0].code(), 4401);
  EXPECT_EQ(frames[0].reason(), std::string(120, 'r'));
  EXPECT_FALSE(end.socket.closed());
  end.socket.receive(client_frame(8, "\x11\x31"));
  EXPECT_TRUE(end.socket.closed());
}

TEST(WebSocket, AnswersAClose) {
  End end;
  end.socket.receive(client_frame(8, std::string("\x03\xE8", 2)));
  EXPECT_EQ(end.sent().at(0).code(), 1000);
  EXPECT_TRUE(end.socket.closed());
}

/// A close code of a frame that the server sends; 0: it sends none.
int closed_by(const std::vector<std::uint8_t>& bytes) {
  End end(1000);
  end.socket.receive(bytes);
  for (const test::Frame& frame : end.sent())
    if (frame.opcode == 8) return frame.code();
  return 0;
}

TEST(WebSocket, ClosesOnWhatIsNoneOfItsFrames) {
  std::vector<std::uint8_t> unmasked = {0x81, 0x01, 'x'};
  EXPECT_EQ(closed_by(unmasked), 1002);
  EXPECT_EQ(closed_by(client_frame(3, "x")), 1002);         // no such opcode
  EXPECT_EQ(closed_by(client_frame(1, "\xFF\xFE")), 1007);  // no UTF-8
  EXPECT_EQ(closed_by(client_frame(1, std::string(1001, 'x'))), 1009);
  EXPECT_EQ(closed_by(client_frame(2, "x")), 4400);  // only text is read
  EXPECT_EQ(closed_by(client_frame(1, std::string(1000, 'x'))), 0);
}

TEST(WebSocket, PassesOnWhatItsReaderThrows) {
  WebSocket socket(100, [](std::string_view) { throw std::runtime_error("no memory, say"); });
  EXPECT_THROW(socket.receive(client_frame(1, "x")), std::runtime_error);
}

}  // namespace
}  // namespace feltwire::websocket_test
