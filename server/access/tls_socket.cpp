#include "server/access/tls_socket.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <asio/error.hpp>
#include <cerrno>
#include <climits>
#include <new>

#include "protocol/crypto/tls.hpp"

namespace feltwire {
namespace {

// Constants of TLS 1.3 (RFC 8446, sections 4 and 5.1).
constexpr std::size_t kRecordHead = 5, kMessageHead = 4;  // [bytes] lengths of the headers
constexpr std::size_t kMostRecord = std::size_t{1} << 14;
constexpr std::uint8_t kHandshakeRecord = 22, kClientHello = 1;

int clamped(std::size_t size) {
  return static_cast<int>(std::min(size, static_cast<std::size_t>(INT_MAX)));
}

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

FirstMessage first_message(std::span<const std::uint8_t> bytes) noexcept {
  std::array<std::uint8_t, kMessageHead> head{};
  std::size_t had = 0;  // [bytes] received of the message, which may span several records
  for (std::size_t at = 0;;) {
    const auto rest = bytes.subspan(at);
    if (!rest.empty() && rest[0] != kHandshakeRecord) return FirstMessage::none;
    if (rest.size() < kRecordHead) break;
    const std::size_t length = std::size_t{rest[3]} << 8U | rest[4];
    if (length == 0 || length > kMostRecord) return FirstMessage::none;
    const auto part = rest.subspan(kRecordHead, std::min(length, rest.size() - kRecordHead));
    for (std::size_t i = 0; i < part.size() && had + i < kMessageHead; ++i) head[had + i] = part[i];
    had += part.size();
    if (had >= 1 && head[0] != kClientHello) return FirstMessage::none;
    if (had >= kMessageHead) {
      const std::size_t whole = kMessageHead + (std::size_t{head[1]} << 16U) +
                                (std::size_t{head[2]} << 8U) + std::size_t{head[3]};
      if (whole > TlsSocket::kMostHello) return FirstMessage::none;
      if (had >= whole) return FirstMessage::whole;
    }
    if (part.size() < length) break;
    at += kRecordHead + length;
  }
  return bytes.size() < TlsSocket::kMostHello ? FirstMessage::incomplete : FirstMessage::none;
}

void TlsSocket::FreeConnection::operator()(ssl_st* connection) const noexcept {
  SSL_free(connection);
}
void TlsSocket::FreeContext::operator()(ssl_ctx_st* context) const noexcept {
  SSL_CTX_free(context);
}

TlsSocket::TlsSocket(asio::ip::tcp::socket socket, ssl_ctx_st& tls) : socket_(std::move(socket)) {
  if (SSL_CTX_up_ref(&tls) != 1) throw std::bad_alloc();
  context_.reset(&tls);
}

TlsSocket::~TlsSocket() = default;

/// Returns the functions with which OpenSSL reads and writes the socket. OpenSSL's own functions
/// would cause SIGPIPE, and so end the program, when the client has closed the connection.
bio_method_st& TlsSocket::transport() {
  static BIO_METHOD* const method = [] {
    BIO_METHOD* const made =
        BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "feltwire socket");
    if (made == nullptr) throw std::bad_alloc();
    BIO_meth_set_read(made, receive);
    BIO_meth_set_write(made, send);
    BIO_meth_set_ctrl(made, answer);
    return made;
  }();
  return *method;
}

int TlsSocket::receive(bio_st* bio, char* into, int size) {
  auto& self = *static_cast<TlsSocket*>(BIO_get_data(bio));
  BIO_clear_retry_flags(bio);
  if (!self.hello_.empty()) {
    const std::size_t count =
        std::min(static_cast<std::size_t>(size), self.hello_.size() - self.hello_read_);
    std::copy_n(self.hello_.begin() + static_cast<std::ptrdiff_t>(self.hello_read_), count, into);
    self.hello_read_ += count;
    if (self.hello_read_ == self.hello_.size()) self.hello_ = std::vector<std::uint8_t>();
    return static_cast<int>(count);
  }
  // Ask for the descriptor at each call: after a close, another socket may have the same number.
  const ssize_t count =
      ::recv(self.socket_.native_handle(), into, static_cast<std::size_t>(size), MSG_DONTWAIT);
  if (count < 0 && would_block()) BIO_set_retry_read(bio);
  return static_cast<int>(count);
}

int TlsSocket::send(bio_st* bio, const char* from, int size) {
  auto& self = *static_cast<TlsSocket*>(BIO_get_data(bio));
  BIO_clear_retry_flags(bio);
  const ssize_t count = ::send(self.socket_.native_handle(), from, static_cast<std::size_t>(size),
                               MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count < 0 && would_block()) BIO_set_retry_write(bio);
  return static_cast<int>(count);
}

long TlsSocket::answer(bio_st*, int request, long, void*) {
  return request == BIO_CTRL_FLUSH ? 1 : 0;
}

void TlsSocket::make_engine() {
  std::unique_ptr<ssl_st, FreeConnection> made(new_tls_connection(*context_));
  BIO* const bio = BIO_new(&transport());
  if (bio == nullptr) throw std::bad_alloc();
  BIO_set_data(bio, this);
  BIO_set_init(bio, 1);
  SSL_set_bio(made.get(), bio, bio);
  SSL_set_mode(made.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                               SSL_MODE_RELEASE_BUFFERS);
  ssl_ = std::move(made);
}

/// Receives bytes of the client's first message (ClientHello). Returns a step without a wait and
/// without an error if the message is complete.
TlsSocket::Step TlsSocket::await_hello() {
  std::array<std::uint8_t, kMostHello> room{};
  for (;;) {
    const ssize_t count =
        ::recv(socket_.native_handle(), room.data(), kMostHello - hello_.size(), MSG_DONTWAIT);
    if (count < 0 && would_block()) return {.waits = Waits::to_read};
    if (count < 0) return {.error = {errno, std::system_category()}};
    if (count == 0) return {.error = asio::error::eof};
    // Reserve memory for the received bytes only.
    hello_.reserve(hello_.size() + static_cast<std::size_t>(count));
    hello_.insert(hello_.end(), room.begin(), room.begin() + count);
    switch (first_message(hello_)) {
      case FirstMessage::incomplete:
        break;
      case FirstMessage::whole:
        return {};
      case FirstMessage::none:
        return {.error = make_error_code(std::errc::protocol_error)};
    }
  }
}

TlsSocket::Step TlsSocket::shake_hands() noexcept {
  try {
    if (ssl_ == nullptr) {
      const Step step = await_hello();
      if (step.waits != Waits::for_nothing || step.error) return step;
      make_engine();
    }
  } catch (const std::bad_alloc&) {
    return {.error = make_error_code(std::errc::not_enough_memory)};
  }
  ERR_clear_error();
  const Step step = outcome(SSL_accept(ssl_.get()));
  if (step.error) drop_unread();
  return step;
}

/// Discards unread bytes after OpenSSL has sent the reason of a refusal. Closing a socket with
/// unread bytes would reset the connection. The client, which may have sent more bytes, would lose
/// the reason.
void TlsSocket::drop_unread() noexcept {
  std::array<std::uint8_t, kMostHello> room{};
  constexpr int kMostReads = 8;
  for (int n = 0; n < kMostReads; ++n)
    if (::recv(socket_.native_handle(), room.data(), room.size(), MSG_DONTWAIT) <= 0) return;
}

TlsSocket::Step TlsSocket::read(asio::mutable_buffer into) noexcept {
  ERR_clear_error();
  return outcome(SSL_read(ssl_.get(), into.data(), clamped(into.size())));
}

TlsSocket::Step TlsSocket::write(asio::const_buffer from) noexcept {
  ERR_clear_error();
  return outcome(SSL_write(ssl_.get(), from.data(), clamped(from.size())));
}

TlsSocket::Step TlsSocket::say_end() noexcept {
  ERR_clear_error();
  const int result = SSL_shutdown(ssl_.get());
  return result >= 0 ? Step{} : outcome(result);
}

/// Converts the result of the last OpenSSL call to a Step.
TlsSocket::Step TlsSocket::outcome(int result) noexcept {
  const int number = errno;
  switch (SSL_get_error(ssl_.get(), result)) {
    case SSL_ERROR_NONE:
      return {.size = static_cast<std::size_t>(result)};
    case SSL_ERROR_WANT_READ:
      return {.waits = Waits::to_read};
    case SSL_ERROR_WANT_WRITE:
      return {.waits = Waits::to_write};
    case SSL_ERROR_ZERO_RETURN:
      return {.error = asio::error::eof};
    case SSL_ERROR_SYSCALL:
      if (number != 0) return {.error = {number, std::system_category()}};
      return {.error = asio::error::eof};
    default:
      return {.error = make_error_code(std::errc::protocol_error)};
  }
}

}  // namespace feltwire
