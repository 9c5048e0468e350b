// A service sends much data without a message. The WebSocket must not block the servo's thread.

#include "client/drivers/haply/service_socket.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace feltwire::service_socket_test {
namespace {

using ReceiveResult = ServiceSocket::ReceiveResult;

constexpr std::size_t kLongest = 1000;
constexpr char kPart = 0, kText = 1, kPing = 9, kPong = 10;

/// Returns an unmasked frame, as a service sends it.
std::string frame(char opcode, const std::string& payload, bool last = true) {
  std::string bytes(1, static_cast<char>((last ? 0x80 : 0) | opcode));
  const std::size_t size = payload.size();
  if (size < 126) {
    bytes += static_cast<char>(size);
  } else {
    bytes += {126, static_cast<char>(size >> 8U), static_cast<char>(size & 0xFFU)};
  }
  return bytes + payload;
}

std::string times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

class ServiceSocketTest : public ::testing::Test {
 protected:
  ServiceSocketTest() { connect(); }
  ~ServiceSocketTest() override { ::close(service_); }

  void connect() {
    if (service_ >= 0) ::close(service_);
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error("no pair of sockets");
    service_ = ends[0];
    socket_ = std::make_unique<ServiceSocket>(ServiceSocket::Connection{ends[1], ""}, kLongest);
  }
  void say(const std::string& bytes) const {
    ASSERT_EQ(::send(service_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  ReceiveResult hear() { return socket_->receive(Nanoseconds(0)); }
  std::size_t answered() const {
    std::string room(1 << 16, '\0');
    const ssize_t count = ::recv(service_, room.data(), room.size(), 0);
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  static constexpr int kMost = ServiceSocket::kMostIdle;
  int service_ = -1;
  std::unique_ptr<ServiceSocket> socket_;
};

TEST_F(ServiceSocketTest, PingsBetweenMessagesAreAnswered) {
  for (int i = 0; i < 3; ++i) {
    say(times(kMost, frame(kPing, "")) + frame(kText, "{}"));
    EXPECT_EQ(hear(), ReceiveResult::message) << i;
    EXPECT_EQ(socket_->message(), "{}");
    constexpr std::size_t kPongBytes = 6;
    EXPECT_EQ(answered(), kMost * kPongBytes);
  }
}

TEST_F(ServiceSocketTest, ControlFramesWithoutEndEndIt) {
  for (const char opcode : {kPing, kPong}) {
    connect();
    say(frame(kText, "{}") + times(1000, frame(opcode, "")));
    EXPECT_EQ(hear(), ReceiveResult::message);
    EXPECT_EQ(hear(), ReceiveResult::gone) << int{opcode};
    EXPECT_EQ(hear(), ReceiveResult::gone) << "and stays so";
  }
}

TEST_F(ServiceSocketTest, PartsWithoutEndEndIt) {
  say(frame(kText, "", false) + times(1000, frame(kPart, "", false)));
  EXPECT_EQ(hear(), ReceiveResult::gone);
}

TEST_F(ServiceSocketTest, AMessageInAFewPartsIsTaken) {
  say(frame(kText, "{", false) + times(kMost - 1, frame(kPart, " ", false)) + frame(kPart, "}"));
  EXPECT_EQ(hear(), ReceiveResult::message);
  EXPECT_EQ(socket_->message().size(), static_cast<std::size_t>(kMost) + 1);
}

TEST_F(ServiceSocketTest, AMessageThatIsTooLongIsReadOver) {
  say(frame(kText, std::string(60'000, 'x')) + frame(kText, "{}"));
  EXPECT_EQ(hear(), ReceiveResult::garbled);
  EXPECT_EQ(hear(), ReceiveResult::message);
  EXPECT_EQ(socket_->message(), "{}");
}

TEST_F(ServiceSocketTest, AFrameWithoutEndEndsIt) {
  std::string head(1, static_cast<char>(0x80 | kText));
  head += std::string("\x7f\x00\x00\x01\x00\x00\x00\x00\x00", 9);  // 2^40 bytes follow.
  say(head + std::string(1000, 'x'));
  EXPECT_EQ(hear(), ReceiveResult::gone);
}

}  // namespace
}  // namespace feltwire::service_socket_test
