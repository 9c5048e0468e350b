// Takes arbitrary bytes from a service on this machine after the handshake, in pieces: complete and
// broken WebSocket frames, fragments, control frames. The client must accept the messages that a
// second decoder of RFC 6455 accepts, and must answer pings. The client must disconnect when the
// service breaks the rules.

#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <stdexcept>
#include <vector>

#include "client/drivers/haply/haply_messages.hpp"
#include "client/drivers/haply/service_socket.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr std::size_t kLongest = 200;  // [bytes] longest message, shorter than an input
constexpr std::size_t kMostPiece = 64;
enum Opcode : unsigned { kMore = 0, kText = 1, kClose = 8, kPing = 9, kPong = 10 };

using Text = std::optional<std::string>;  // of a message; none: too long

struct Frame {
  unsigned opcode = 0, reserved = 0;
  bool last = false, masked = false;
  bool possible = true;  // The length has the required form.
  std::uint64_t size = 0;
  std::size_t head = 0;  // [bytes] length of the head
};

/// Returns the first frame by RFC 6455, 5.2, or nothing if its head is incomplete.
std::optional<Frame> frame_at(Bytes bytes) {
  if (bytes.size() < 2) return std::nullopt;
  Frame frame{.opcode = bytes[0] & 15U,
              .reserved = bytes[0] >> 4U & 7U,
              .last = bytes[0] >> 7U != 0,
              .masked = bytes[1] >> 7U != 0,
              .size = bytes[1] & 127U,
              .head = 2};
  if (frame.opcode >= kClose) frame.possible = frame.last && frame.size <= 125;
  if (!frame.possible) return frame;  // The rest of the head is ignored.
  const std::size_t more = frame.size == 126 ? 2 : frame.size == 127 ? 8 : 0;
  if (bytes.size() < frame.head + more) return std::nullopt;
  if (more > 0) frame.size = 0;
  for (std::size_t n = 0; n < more; ++n) frame.size = frame.size << 8U | bytes[2 + n];
  if (more == 2) frame.possible = frame.size >= 126;
  if (more == 8) frame.possible = frame.size >= 65536 && frame.size >> 63U == 0;
  frame.head += more + (frame.masked ? 4 : 0);
  if (bytes.size() < frame.head && frame.possible) return std::nullopt;
  return frame;
}

/// The client's required reactions to the bytes.
struct RequiredReactions {
  std::vector<Text> messages;
  std::vector<std::string> pings;
  bool ends = false;     // a close frame, or a certainly broken rule
  bool may_end = false;  // a broken rule in an incomplete frame
};

RequiredReactions heard(Bytes bytes) {
  RequiredReactions all;
  bool begun = false;
  int idle = 0;                 // consecutive frames without the end of a message
  std::uint64_t announced = 0;  // [bytes] announced length of this message so far
  std::string text;
  while (const auto frame = frame_at(bytes)) {
    const bool control = frame->opcode >= kClose;
    const bool known = frame->opcode == kMore || frame->opcode == kText ||
                       frame->opcode == kClose || frame->opcode == kPing || frame->opcode == kPong;
    const bool in_turn = control || begun == (frame->opcode == kMore);
    if (!frame->possible) return all.ends = true, all;
    const Bytes body = bytes.subspan(frame->head);
    if (!control) announced += frame->size;
    const bool endless = announced > ServiceSocket::kMostSkipped;
    if (!known || !in_turn || frame->masked || frame->reserved != 0 || endless) {
      (frame->size == 0 || !body.empty() ? all.ends : all.may_end) = true;
      return all;
    }
    if (body.size() < frame->size) return all;
    const auto size = static_cast<std::size_t>(frame->size);
    const std::string data(body.begin(), body.begin() + static_cast<std::ptrdiff_t>(size));
    bytes = body.subspan(size);
    const bool ends_message = !control && frame->last;
    idle = ends_message ? 0 : idle + 1;
    if (idle > ServiceSocket::kMostIdle) return all.ends = true, all;
    if (frame->opcode == kClose) return all.ends = true, all;
    if (frame->opcode == kPing) all.pings.push_back(data);
    if (control) continue;
    text += data;
    begun = !frame->last;
    if (begun) continue;
    all.messages.push_back(text.size() <= kLongest ? Text(text) : std::nullopt);
    text.clear();
    announced = 0;
  }
  return all;
}

/// Returns the client's pongs. Each must be masked, as all frames of a client.
std::vector<std::string> pongs_in(const std::string& sent) {
  std::vector<std::string> pongs;
  Bytes bytes(reinterpret_cast<const std::uint8_t*>(sent.data()), sent.size());
  while (!bytes.empty()) {
    const auto frame = frame_at(bytes);
    require(frame && frame->possible && frame->masked && frame->last && frame->opcode == kPong &&
                frame->reserved == 0 && bytes.size() >= frame->head + frame->size,
            "the client answers with whole, masked pongs");
    const Bytes key = bytes.subspan(frame->head - 4, 4);
    const auto size = static_cast<std::size_t>(frame->size);
    std::string data;
    for (std::size_t n = 0; n < size; ++n)
      data += static_cast<char>(bytes[frame->head + n] ^ key[n % 4]);
    pongs.push_back(data);
    bytes = bytes.subspan(frame->head + size);
  }
  return pongs;
}

/// A service that sends the input.
class Service {
 public:
  Service() {
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends_) != 0)
      throw std::runtime_error("no pair of sockets");
  }
  ~Service() { ::close(ends_[0]); }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  int client() const { return ends_[1]; }
  void say(Bytes bytes) const {
    require(::send(ends_[0], bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
                static_cast<ssize_t>(bytes.size()),
            "what is said has room");
  }
  void listen() {
    char room[4096];
    for (ssize_t count; (count = ::recv(ends_[0], room, sizeof room, 0)) > 0;)
      sent.append(room, static_cast<std::size_t>(count));
  }
  std::string sent;  // bytes from the client

 private:
  int ends_[2];
};

/// Takes the available messages. Returns false if the connection is gone.
bool take(ServiceSocket& socket, std::vector<Text>& messages) {
  while (true) {
    switch (socket.receive(Nanoseconds(0))) {
      case ServiceSocket::ReceiveResult::none:
        return true;
      case ServiceSocket::ReceiveResult::gone:
        return false;
      case ServiceSocket::ReceiveResult::garbled:
        messages.emplace_back();
        break;
      case ServiceSocket::ReceiveResult::message:
        messages.emplace_back(socket.message());
        haply::read_message(socket.message(), "");
        break;
    }
  }
}

void run(Input& input) {
  Service service;
  std::vector<std::uint8_t> said;
  const auto piece = [&] {
    const Bytes bytes = input.bytes(1U + input.byte() % kMostPiece);
    said.insert(said.end(), bytes.begin(), bytes.end());
    return bytes;
  };
  std::string early;
  if (input.coin()) {
    const Bytes bytes = piece();
    early.assign(bytes.begin(), bytes.end());
  }
  ServiceSocket socket({service.client(), early}, kLongest);
  std::vector<Text> messages;
  bool there = take(socket, messages);
  while (there && !input.empty()) {
    service.say(piece());
    there = take(socket, messages);
    service.listen();
  }
  service.listen();
  const RequiredReactions expected = heard(said);
  require(messages == expected.messages, "the messages are those of the frames");
  require(there ? !expected.ends : expected.ends || expected.may_end,
          "the connection is gone where the service breaks the rules or closes it");
  require(pongs_in(service.sent) == expected.pings, "each ping has its answer");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  feltwire::fuzz::Input input(data, size);
  feltwire::fuzz::run(input);
  return 0;
}
