// Tests the server's side of TLS: its memory for a silent client, its checks of the first message,
// and complete delivery.

#include "server/access/tls_socket.hpp"

#include <gtest/gtest.h>

#include <asio/io_context.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <optional>
#include <thread>

#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/tls.hpp"

namespace feltwire::tls_socket_test {
namespace {

using asio::ip::tcp;
using Bytes = std::vector<std::uint8_t>;

/// Returns the first message of an OpenSSL client in a single record.
Bytes hello() {
  const test::TlsContext context = test::client_context();
  const std::unique_ptr<SSL, decltype(&SSL_free)> client(SSL_new(context.get()), &SSL_free);
  BIO* const input = BIO_new(BIO_s_mem());
  BIO* const output = BIO_new(BIO_s_mem());
  SSL_set_bio(client.get(), input, output);
  SSL_connect(client.get());
  Bytes bytes(4096);
  const int size = BIO_read(output, bytes.data(), static_cast<int>(bytes.size()));
  bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return bytes;
}

/// Returns these bytes as a record of the handshake.
Bytes record(std::span<const std::uint8_t> part) {
  Bytes bytes = {22, 3, 1, static_cast<std::uint8_t>(part.size() >> 8U),
                 static_cast<std::uint8_t>(part.size())};
  bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

/// Splits the message of a record into records of this size.
Bytes in_records(std::span<const std::uint8_t> one, std::size_t size) {
  Bytes all;
  for (std::span<const std::uint8_t> rest = one.subspan(5); !rest.empty();) {
    const auto part = rest.first(std::min(size, rest.size()));
    const Bytes next = record(part);
    all.insert(all.end(), next.begin(), next.end());
    rest = rest.subspan(part.size());
  }
  return all;
}

/// Returns the head of a ClientHello of `message` bytes, in a record of `in_record` bytes.
Bytes announced(std::size_t message, std::size_t in_record) {
  const auto byte = [](std::size_t value) { return static_cast<std::uint8_t>(value); };
  return {22,
          3,
          1,
          byte(in_record >> 8U),
          byte(in_record),
          1,
          byte(message >> 16U),
          byte(message >> 8U),
          byte(message)};
}

class TlsSocketTest : public ::testing::Test {
 protected:
  TlsSocketTest() { shake_hands(); }
  ~TlsSocketTest() override {
    server_->next_layer().close();
    poll();
  }

  void shake_hands() {
    server_->async_handshake([this](const std::error_code& error) { shaken_ = error; });
  }
  void poll() {
    io_.poll();
    io_.restart();
  }
  /// Returns true after the socket has made its TLS engine.
  bool has_engine() const { return server_->native_handle() != nullptr; }

  static tcp::socket accepted(asio::io_context& io, std::optional<test::RawSocket>& client) {
    tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    client.emplace(SOCK_STREAM, acceptor.local_endpoint().port());
    tcp::socket socket = acceptor.accept();
    socket.non_blocking(true);
    return socket;
  }

  asio::io_context io_{1};
  const test::TlsContext context_ = test::server_context(test::identity());
  std::optional<test::RawSocket> client_;
  std::unique_ptr<TlsSocket> server_ =
      std::make_unique<TlsSocket>(accepted(io_, client_), *context_);
  std::optional<std::error_code> shaken_;  // empty until the handshake ends
};

/// The first message arrives byte by byte.
TEST_F(TlsSocketTest, HasNoEngineBeforeTheFirstMessageIsWhole) {
  const Bytes all = hello();
  ASSERT_GT(all.size(), 100u);
  for (std::size_t i = 0; i < all.size(); ++i) {
    poll();
    ASSERT_FALSE(has_engine()) << i;
    client_->send(std::span(all).subspan(i, 1));
  }
  test::eventually("the engine", [&] {
    poll();
    return has_engine();
  });
  EXPECT_EQ(client_->receive(5).at(0), 22) << "the server's answer";
  EXPECT_FALSE(shaken_);
}

TEST_F(TlsSocketTest, TakesAFirstMessageInManyRecords) {
  for (const std::size_t size : {1u, 2u, 3u, 4u, 7u, 100u}) {
    const Bytes records = in_records(hello(), size);
    ASSERT_LT(records.size(), TlsSocket::kMostHello);
    EXPECT_EQ(first_message(records), FirstMessage::whole) << size;
    for (std::size_t i = 0; i < records.size(); ++i)
      ASSERT_EQ(first_message(std::span(records).first(i)), FirstMessage::incomplete) << i;
  }
  client_->send(in_records(hello(), 100));
  test::eventually("the engine", [&] {
    poll();
    return has_engine();
  });
  EXPECT_EQ(client_->receive(5).at(0), 22);
}

/// OpenSSL would allocate 128 KiB at once for a message of 131392 bytes.
TEST_F(TlsSocketTest, RefusesAFirstMessageThatIsTooLong) {
  constexpr std::size_t kMost = TlsSocket::kMostHello;
  EXPECT_EQ(first_message(announced(131'392, 16'384)), FirstMessage::none);
  EXPECT_EQ(first_message(announced(kMost - 3, 16'384)), FirstMessage::none);
  EXPECT_EQ(first_message(announced(kMost - 4, 16'384)), FirstMessage::incomplete);
  EXPECT_EQ(first_message(announced(500, 16'385)), FirstMessage::none);
  EXPECT_EQ(first_message(announced(500, 0)), FirstMessage::none);
  client_->send(announced(131'392, 16'384));
  test::eventually("the end of the handshake", [&] {
    poll();
    return shaken_.has_value();
  });
  EXPECT_TRUE(*shaken_);
  EXPECT_FALSE(has_engine());
}

/// Record headers must count too.
TEST_F(TlsSocketTest, RefusesAFirstMessageThatNeverEnds) {
  Bytes bytes = in_records(record(Bytes{1, 0, 31, 0}), 1);  // 7936 bytes are missing.
  const Bytes more = record(Bytes{0});
  while (bytes.size() < 2 * TlsSocket::kMostHello)
    bytes.insert(bytes.end(), more.begin(), more.end());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    ASSERT_EQ(first_message(std::span(bytes).first(i)),
              i < TlsSocket::kMostHello ? FirstMessage::incomplete : FirstMessage::none)
        << i;
}

TEST_F(TlsSocketTest, RefusesWhatIsNoFirstMessage) {
  const Bytes other_record = {23}, other_message = {22, 3, 1, 0, 4, 2}, text = {'G', 'E', 'T'};
  for (const Bytes& bytes : {other_record, other_message, text})
    EXPECT_EQ(first_message(bytes), FirstMessage::none);
  EXPECT_EQ(first_message({}), FirstMessage::incomplete);
  client_->send(text);
  test::eventually("the end of the handshake", [&] {
    poll();
    return shaken_.has_value();
  });
  EXPECT_TRUE(*shaken_);
}

TEST_F(TlsSocketTest, SaysThatTheClientHasGone) {
  client_->send(Bytes{22, 3});
  poll();
  client_.reset();
  test::eventually("the end of the handshake", [&] {
    poll();
    return shaken_.has_value();
  });
  EXPECT_EQ(*shaken_, asio::error::eof);
}

/// The server sends long answers. The client reads late and sends as much.
TEST_F(TlsSocketTest, LosesNothing) {
  constexpr std::size_t kSize = 3'000'000;
  Bytes from_client(kSize), from_server(kSize);
  for (std::size_t i = 0; i < kSize; ++i) {
    from_client[i] = static_cast<std::uint8_t>(i * 7);
    from_server[i] = static_cast<std::uint8_t>(i * 11);
  }
  const Bytes head = {'h', 'e', 'a', 'd'};
  Bytes read_by_client, read_by_server(kSize);
  bool ended = false;
  std::thread client([&] {
    const test::TlsContext context = test::client_context();
    test::TlsConnection tls(context.get(), client_->descriptor());
    ASSERT_TRUE(tls.connect());
    ASSERT_TRUE(tls.write(from_client));
    read_by_client = tls.read(head.size() + kSize);
    ended = tls.read(1).empty() && (SSL_get_shutdown(tls.native()) & SSL_RECEIVED_SHUTDOWN) != 0;
  });
  int under_way = 1;
  std::error_code wrong;
  const auto done = [&](const std::error_code& error) {
    if (error) wrong = error;
    if (--under_way > 0) return;
    server_->async_shutdown([&](const std::error_code&) {
      under_way = -1;
      server_->next_layer().close();
    });
  };
  test::eventually("the handshake", [&] {
    poll();
    return shaken_.has_value();
  });
  ASSERT_FALSE(*shaken_) << shaken_->message();
  under_way = 2;
  asio::async_read(*server_, asio::buffer(read_by_server),
                   [&](const std::error_code& error, std::size_t) { done(error); });
  const std::array<asio::const_buffer, 3> parts = {asio::const_buffer(), asio::buffer(head),
                                                   asio::buffer(from_server)};
  asio::async_write(*server_, parts,
                    [&](const std::error_code& error, std::size_t) { done(error); });
  test::eventually("the end", [&] {
    poll();
    return under_way < 0 || wrong;
  });
  client.join();
  EXPECT_FALSE(wrong) << wrong.message();
  EXPECT_EQ(read_by_server, from_client);
  ASSERT_EQ(read_by_client.size(), head.size() + kSize);
  EXPECT_TRUE(std::equal(head.begin(), head.end(), read_by_client.begin()));
  EXPECT_TRUE(std::equal(from_server.begin(), from_server.end(), read_by_client.begin() + 4));
  EXPECT_TRUE(ended);
}

/// A close during a waiting write must drop the data. No later socket with this number may get this
/// data.
TEST_F(TlsSocketTest, EndsWhatIsUnderWayWhenItIsClosed) {
  std::thread client([&] {
    const test::TlsContext context = test::client_context();
    test::TlsConnection tls(context.get(), client_->descriptor());
    ASSERT_TRUE(tls.connect());
  });
  test::eventually("the handshake", [&] {
    poll();
    return shaken_.has_value();
  });
  client.join();
  const Bytes much(30'000'000);
  std::array<std::uint8_t, 16> room{};
  std::optional<std::error_code> read, written;
  asio::async_write(*server_, asio::buffer(much),
                    [&](const std::error_code& error, std::size_t) { written = error; });
  server_->async_read_some(asio::buffer(room),
                           [&](const std::error_code& error, std::size_t) { read = error; });
  poll();
  EXPECT_FALSE(read);
  EXPECT_FALSE(written);
  server_->next_layer().close();
  poll();
  EXPECT_TRUE(read && *read);
  EXPECT_TRUE(written && *written);
}

}  // namespace
}  // namespace feltwire::tls_socket_test
