// Tests the server's end of a WebSocket byte by byte: complete messages, split messages and invalid
// bytes.

#include "server/web/websocket.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>

#include "tests/server/web/frames.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::websocket_test {
namespace {

using test::client_frame;

struct End {
  explicit End(std::size_t most = 1000)
      : socket(
            most, [this](std::string_view message) { said.emplace_back(message); },
            [this] { ++begun; }) {}

  /// Returns all frames that the socket wants to send.
  std::vector<test::Frame> sent() {
    std::vector<std::uint8_t> bytes;
    for (auto next = socket.take_output(); !next.empty(); next = socket.take_output()) {
      bytes.insert(bytes.end(), next.own.begin(), next.own.end());
      bytes.insert(bytes.end(), next.shared.bytes().begin(), next.shared.bytes().end());
    }
    std::vector<test::Frame> frames;
    while (const auto frame = test::take_frame(bytes)) frames.push_back(*frame);
    EXPECT_TRUE(bytes.empty());
    return frames;
  }

  std::vector<std::string> said;
  int begun = 0;  // number of frames
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
  end.socket.send_binary(web::SharedBytes(large));
  EXPECT_TRUE(end.socket.has_output());
  const auto frames = end.sent();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].opcode, 1);
  EXPECT_EQ(frames[0].text(), "hello");
  EXPECT_EQ(frames[1].opcode, 2);
  EXPECT_EQ(frames[1].payload, large);
  EXPECT_FALSE(end.socket.has_output());
}

TEST(WebSocket, AMessageBeginsWithItsOwnBytes) {
  End end;
  const std::vector<std::uint8_t> head = {1, 2, 3};
  for (const std::size_t size : {0u, 1u, 122u, 123u, 65'532u, 65'533u}) {
    end.socket.send_binary(web::SharedBytes(std::string(size, 'x')), head);
    const auto frames = end.sent();
    ASSERT_EQ(frames.size(), 1u) << size;
    EXPECT_EQ(frames[0].text(), "\1\2\3" + std::string(size, 'x'));
  }
}

/// A large scene for a hundred viewers must be stored once.
TEST(WebSocket, ALongSharedMessageIsNotCopied) {
  const web::SharedBytes scene(std::vector<std::uint8_t>(1'000'000, 7));
  std::vector<std::unique_ptr<End>> ends;
  for (int i = 0; i < 3; ++i) {
    End& end = *ends.emplace_back(std::make_unique<End>());
    end.socket.send_text("news");
    end.socket.send_binary(scene);
    end.socket.send_binary(scene);
    EXPECT_LT(end.socket.waiting(), 100u);
    for (int n = 0; n < 2; ++n)
      EXPECT_EQ(end.socket.take_output().shared.bytes().data(), scene.bytes().data());
    EXPECT_EQ(end.socket.waiting(), 0u);
  }
}

TEST(WebSocket, ShortMessagesAreWrittenTogether) {
  End end;
  for (int i = 0; i < 100; ++i) end.socket.send_text("news");
  EXPECT_EQ(end.socket.waiting(), 600u);
  EXPECT_EQ(end.socket.take_output().own.size(), 600u);
  EXPECT_EQ(end.socket.waiting(), 0u);
  EXPECT_FALSE(end.socket.has_output());
}

/// The socket must count each frame at its beginning, so that a limit can bound the memory.
TEST(WebSocket, CountsEveryFrameThatBegins) {
  End end;
  end.socket.receive(client_frame(1, "whole"));
  end.socket.receive(client_frame(9, ""));
  end.socket.receive(client_frame(10, "unasked"));
  EXPECT_EQ(end.begun, 3);
  end.socket.receive(client_frame(1, "", false));
  for (int i = 0; i < 5; ++i) end.socket.receive(client_frame(0, "", false));
  end.socket.receive(client_frame(9, "between"));
  EXPECT_EQ(end.begun, 10);
  const auto head = client_frame(0, std::string(500, 'x'));
  end.socket.receive(std::span(head).first(20));
  EXPECT_EQ(end.begun, 11) << "also one that has not come in whole";
  EXPECT_EQ(end.said, std::vector<std::string>{"whole"});
}

TEST(WebSocket, TakesAndAnswersNothingAfterItsClose) {
  std::vector<std::string> said;
  WebSocket* itself = nullptr;
  WebSocket socket(
      1000, [&](std::string_view message) { said.emplace_back(message); },
      [&] { itself->close(WebSocketClose::bad_message, "too many"); });
  itself = &socket;
  std::vector<std::uint8_t> bytes;
  for (const auto& frame : {client_frame(1, "x"), client_frame(9, "y"), client_frame(1, "z")})
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  EXPECT_TRUE(socket.reads());
  EXPECT_TRUE(socket.receive(bytes));
  EXPECT_FALSE(socket.reads());
  EXPECT_TRUE(said.empty());
  std::vector<std::uint8_t> sent = socket.take_output().own;
  const auto close = test::take_frame(sent);
  ASSERT_TRUE(close);
  EXPECT_EQ(close->code(), 4400);
  EXPECT_TRUE(sent.empty());
}

TEST(WebSocket, StoresNothingAfterItsClose) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers bring their own allocator";
#endif
  End end;
  end.socket.close(WebSocketClose::bad_message, "enough");
  std::vector<std::uint8_t> bytes = client_frame(1, "x", false);
  for (int i = 0; i < 900; ++i) {
    const auto part = client_frame(0, "x", false);
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  const std::size_t before = test::allocations();
  EXPECT_TRUE(end.socket.receive(bytes));
  EXPECT_EQ(test::allocations() - before, 0u);
  end.socket.receive(client_frame(0, ""));
  end.socket.receive(client_frame(8, "\x11\x31"));
  end.socket.take_output();
  EXPECT_TRUE(end.socket.closed()) << "its close is still heard";
}

TEST(WebSocket, AnswersAPing) {
  End end;
  end.socket.receive(client_frame(9, "there?"));
  const auto frames = end.sent();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].opcode, 10);
  EXPECT_EQ(frames[0].text(), "there?");
}

TEST(WebSocket, PingsUntilItsClose) {
  End end;
  end.socket.send_text("news");
  end.socket.ping();
  std::vector<int> opcodes;
  for (const test::Frame& frame : end.sent()) opcodes.push_back(frame.opcode);
  EXPECT_EQ(opcodes, (std::vector<int>{9, 1}));
  EXPECT_TRUE(end.socket.receive(client_frame(10, "")));
  EXPECT_EQ(end.begun, 1) << "the answer is a frame of the other end";
  EXPECT_TRUE(end.said.empty());
  end.socket.close(WebSocketClose::going_away, "");
  end.socket.ping();
  EXPECT_EQ(end.sent().size(), 1u);
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

TEST(WebSocket, NothingFollowsAClose) {
  End end;
  end.socket.send_text("too late");
  end.socket.receive(client_frame(8, std::string("\x03\xE8", 2)));
  end.socket.send_text("later still");
  EXPECT_FALSE(end.socket.reads());
  EXPECT_EQ(end.sent().size(), 1u);
  EXPECT_FALSE(end.socket.has_output());
  EXPECT_EQ(end.socket.waiting(), 0u);
}

TEST(WebSocket, AnswersAClose) {
  End end;
  end.socket.receive(client_frame(8, std::string("\x03\xE8", 2)));
  EXPECT_EQ(end.sent().at(0).code(), 1000);
  EXPECT_TRUE(end.socket.closed());
}

/// Returns the close code that the server sends, or 0.
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
  EXPECT_EQ(closed_by(client_frame(3, "x")), 1002);         // an unknown opcode
  EXPECT_EQ(closed_by(client_frame(1, "\xFF\xFE")), 1007);  // not UTF-8
  EXPECT_EQ(closed_by(client_frame(1, std::string(1001, 'x'))), 1009);
  EXPECT_EQ(closed_by(client_frame(2, "x")), 4400);  // The server accepts only text.
  EXPECT_EQ(closed_by(client_frame(1, std::string(1000, 'x'))), 0);
}

TEST(WebSocket, PassesOnWhatItsReaderThrows) {
  WebSocket socket(100, [](std::string_view) { throw std::runtime_error("no memory, say"); });
  EXPECT_THROW(socket.receive(client_frame(1, "x")), std::runtime_error);
}

}  // namespace
}  // namespace feltwire::websocket_test
