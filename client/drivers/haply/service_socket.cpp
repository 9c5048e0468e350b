#include "client/drivers/haply/service_socket.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/evp.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>
#include <wslay/wslay.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/base/splitmix.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/poll_until.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kHandshake = std::chrono::seconds(3);
constexpr std::size_t kLongestHead = 4096;
constexpr const char* kNoRandomNumbers = "the system has no source of random numbers";
constexpr std::string_view kMagic = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // RFC 6455, 1.3

[[noreturn]] void refuse(std::uint16_t port, const std::string& why) {
  throw std::runtime_error("127.0.0.1:" + std::to_string(port) + ": " + why);
}

std::string base64(std::span<const unsigned char> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int size = ::EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

/// Returns the answer to `key` that the WebSocket handshake requires.
std::string accepted(const std::string& key) {
  const std::string text = key + std::string(kMagic);
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned size = 0;
  ::EVP_Digest(text.data(), text.size(), hash.data(), &size, ::EVP_sha1(), nullptr);
  return base64(std::span(hash).first(size));
}

/// Connects the socket and makes the WebSocket handshake. Returns the bytes that arrived after the
/// service's answer.
std::string shake_hands(int descriptor, std::uint16_t port) {
  const Nanoseconds latest = monotonic_now() + kHandshake;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  int error = 0;
  if (::connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    error = errno;
  if (error == EINPROGRESS) {
    socklen_t size = sizeof error;
    if (!poll_until(descriptor, POLLOUT, latest))
      error = ETIMEDOUT;
    else
      ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
  }
  if (error != 0) refuse(port, "no service listens: " + std::generic_category().message(error));
  const int on = 1;
  ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);

  std::array<unsigned char, 16> random{};
  if (::getentropy(random.data(), random.size()) != 0) refuse(port, kNoRandomNumbers);
  const std::string key = base64(random);
  const std::string request = "GET / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                              "Sec-WebSocket-Key: " +
                              key + "\r\nSec-WebSocket-Version: 13\r\n\r\n";
  ::send(descriptor, request.data(), request.size(), MSG_DONTWAIT | MSG_NOSIGNAL);

  std::string head;
  std::array<char, 1024> room{};
  std::size_t end = std::string::npos;
  while ((end = head.find("\r\n\r\n")) == std::string::npos) {
    if (head.size() > kLongestHead || !poll_until(descriptor, POLLIN, latest))
      refuse(port,
             "the program at this port is not a WebSocket service; give the port of the maker's "
             "service");
    const ssize_t count = ::recv(descriptor, room.data(), room.size(), 0);
    if (count <= 0) refuse(port, "the service closed the connection; is another program using it?");
    head.append(room.data(), static_cast<std::size_t>(count));
  }
  std::string early = head.substr(end + 4);
  head.resize(end + 2);
  if (!head.starts_with("HTTP/1.1 101") ||
      head.find(": " + accepted(key) + "\r\n") == std::string::npos)
    refuse(port,
           "the program at this port is not a WebSocket service; give the port of the maker's "
           "service");
  return early;
}

ServiceSocket::Connection connected(std::uint16_t port) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), "no socket");
  try {
    return {descriptor, shake_hands(descriptor, port)};
  } catch (...) {
    ::close(descriptor);
    throw;
  }
}

}  // namespace

void ServiceSocket::Free::operator()(wslay_frame_context* context) const noexcept {
  ::wslay_frame_context_free(context);
}

ServiceSocket::ServiceSocket(std::uint16_t port, std::size_t longest_message)
    : ServiceSocket(connected(port), longest_message) {}

ServiceSocket::ServiceSocket(Connection connection, std::size_t longest_message)
    : connection_(std::move(connection)), message_(longest_message) {
  const wslay_frame_callbacks calls{
      .send_callback = keep, .recv_callback = read_more, .genmask_callback = mask};
  wslay_frame_context* context = nullptr;
  const bool random = ::getentropy(&masks_, sizeof masks_) == 0;
  if (random && ::wslay_frame_context_init(&context, &calls, this) == 0) {
    context_.reset(context);
    return;
  }
  ::close(connection_.descriptor);
  if (random) throw std::bad_alloc();
  throw std::runtime_error(kNoRandomNumbers);
}

ServiceSocket::~ServiceSocket() {
  post(framed(WSLAY_CONNECTION_CLOSE, {}));
  ::close(connection_.descriptor);
}

std::ptrdiff_t ServiceSocket::read_more(std::uint8_t* room, std::size_t size, int,
                                        void* self) noexcept {
  auto& socket = *static_cast<ServiceSocket*>(self);
  const std::string& early = socket.connection_.early;
  if (socket.early_taken_ < early.size()) {
    const std::size_t count = std::min(size, early.size() - socket.early_taken_);
    std::copy_n(early.data() + socket.early_taken_, count, room);
    socket.early_taken_ += count;
    return static_cast<std::ptrdiff_t>(count);
  }
  const ssize_t count = ::recv(socket.connection_.descriptor, room, size, MSG_DONTWAIT);
  if (count > 0) return count;
  socket.gone_ |= count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
  return -1;
}

std::ptrdiff_t ServiceSocket::keep(const std::uint8_t* data, std::size_t size, int,
                                   void* self) noexcept {
  auto& socket = *static_cast<ServiceSocket*>(self);
  const std::size_t count = std::min(size, socket.out_.size() - socket.out_size_);
  std::copy_n(data, count, socket.out_.begin() + static_cast<std::ptrdiff_t>(socket.out_size_));
  socket.out_size_ += count;
  return count > 0 ? static_cast<std::ptrdiff_t>(count) : -1;
}

int ServiceSocket::mask(std::uint8_t* room, std::size_t size, void* self) noexcept {
  auto& socket = *static_cast<ServiceSocket*>(self);
  std::uint64_t bits = splitmix::mix(socket.masks_ += splitmix::kStep);
  for (std::size_t n = 0; n < size; ++n, bits >>= 8U) room[n] = static_cast<std::uint8_t>(bits);
  return 0;
}

std::span<const std::uint8_t> ServiceSocket::framed(std::uint8_t opcode,
                                                    std::span<const std::uint8_t> data) noexcept {
  out_size_ = 0;
  wslay_frame_iocb frame{};
  frame.fin = 1;
  frame.opcode = opcode;
  frame.mask = 1;
  frame.payload_length = data.size();
  frame.data = data.data();
  frame.data_length = data.size();
  if (data.size() > kMostSent || !context_ || ::wslay_frame_send(context_.get(), &frame) < 0)
    out_size_ = 0;
  return std::span(out_).first(out_size_);
}

bool ServiceSocket::post(std::span<const std::uint8_t> frame) const noexcept {
  const ssize_t sent =
      ::send(connection_.descriptor, frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent == static_cast<ssize_t>(frame.size());
}

ServiceSocket::Frame ServiceSocket::frame(std::string_view text) {
  const auto bytes = framed(
      WSLAY_TEXT_FRAME, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  return {bytes.begin(), bytes.end()};
}

bool ServiceSocket::send(std::string_view text) noexcept {
  const auto bytes = framed(
      WSLAY_TEXT_FRAME, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  gone_ |= bytes.empty() || !post(bytes);
  return !gone_;
}

ServiceSocket::ReceiveResult ServiceSocket::receive(Nanoseconds latest) noexcept {
  if (gone_) return ReceiveResult::gone;
  if (ended_) {
    size_ = 0;
    announced_ = 0;
    begun_ = ended_ = too_long_ = false;
  }
  while (true) {
    const ReceiveResult news = take_frames(latest);
    if (news != ReceiveResult::none || monotonic_now() >= latest) return news;
    poll_until(connection_.descriptor, POLLIN, latest);
  }
}

/// Receives frames or parts of frames until the end of a message or `latest`. Receives at least one
/// part.
ServiceSocket::ReceiveResult ServiceSocket::take_frames(Nanoseconds latest) noexcept {
  while (!ended_) {
    wslay_frame_iocb part{};
    const ssize_t count = ::wslay_frame_recv(context_.get(), &part);
    if (count == WSLAY_ERR_WANT_READ && !gone_) return ReceiveResult::none;
    if (count < 0) return ReceiveResult::gone;
    const auto size = static_cast<std::size_t>(count);
    const bool control = part.opcode == WSLAY_PING || part.opcode == WSLAY_PONG ||
                         part.opcode == WSLAY_CONNECTION_CLOSE;
    const bool text = part.opcode == WSLAY_TEXT_FRAME || part.opcode == WSLAY_CONTINUATION_FRAME;
    // Whether a message starts twice, or continues without a start.
    const bool odd = of_frame_ == 0 && text && begun_ == (part.opcode == WSLAY_TEXT_FRAME);
    const bool masked = part.mask != 0;   // only frames of a client are masked (RFC 6455, 5.1)
    const bool extended = part.rsv != 0;  // the handshake agreed on no extension (5.2)
    if (text && of_frame_ == 0) announced_ += part.payload_length;
    const bool endless = announced_ > std::max<std::uint64_t>(message_.size(), kMostSkipped);
    if ((!control && !text) || odd || masked || extended || endless)
      return gone_ = true, ReceiveResult::gone;
    if (control) {
      const std::size_t room = control_.size() - control_size_;
      std::copy_n(part.data, std::min(size, room), control_.data() + control_size_);
      control_size_ += std::min(size, room);
    } else {
      const std::size_t kept = std::min(size, message_.size() - size_);
      std::copy_n(part.data, kept, message_.data() + size_);
      size_ += kept;
      too_long_ |= kept < size;
      begun_ = true;
    }
    of_frame_ += size;
    if (of_frame_ >= part.payload_length) {
      of_frame_ = 0;
      ended_ = !control && part.fin != 0;
      idle_ = ended_ ? 0 : idle_ + 1;
      if (idle_ > kMostIdle) return gone_ = true, ReceiveResult::gone;
      if (control) take_control(part.opcode);
      if (gone_) return ReceiveResult::gone;
    }
    if (!ended_ && latest.count() > 0 && monotonic_now() >= latest) return ReceiveResult::none;
  }
  return too_long_ ? ReceiveResult::garbled : ReceiveResult::message;
}

void ServiceSocket::take_control(std::uint8_t opcode) noexcept {
  if (opcode == WSLAY_PING)
    gone_ |= !post(framed(WSLAY_PONG, std::span(control_).first(control_size_)));
  gone_ |= opcode == WSLAY_CONNECTION_CLOSE;
  control_size_ = 0;
}

}  // namespace feltwire
