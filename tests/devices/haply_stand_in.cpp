#include "tests/devices/haply_stand_in.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/evp.h>
#include <openssl/sha.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "tests/devices/scripted.hpp"

namespace stand_in {
namespace {

constexpr double kCommandTick = 1e-3;            // [s]
constexpr double kBack = -0.12, kHeight = 0.15;  // [m] origin of the mass
constexpr unsigned kFinal = 0x80, kText = 1, kMore = 0, kPing = 9;

std::string xyz(double x, double y, double z) {
  return "{\"x\": " + std::to_string(x) + ", \"y\": " + std::to_string(y) +
         ", \"z\": " + std::to_string(z) + "}";
}

/// Returns the number after "NAME": in the text.
double number_behind(std::string_view text, std::string_view name) {
  const std::size_t at = text.find("\"" + std::string(name) + "\":");
  return at == std::string_view::npos
             ? std::nan("")
             : std::strtod(std::string(text.substr(at + name.size() + 3, 40)).c_str(), nullptr);
}

}  // namespace

HaplyService::HaplyService(Json json)
    : json_(json), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  mass.position = {0.0, 0.0, 0.004};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 1) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::runtime_error("no port");
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { run(); });
}

HaplyService::~HaplyService() {
  stop();
  ::close(listener_);
}

void HaplyService::stop() {
  over_.store(true);
  if (thread_.joinable()) thread_.join();
}

void HaplyService::run() {
  while (!over_.load()) {
    pollfd state{listener_, POLLIN, 0};
    if (::poll(&state, 1, 1) <= 0) continue;
    peer_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    heard_.clear();
    const int on = 1;
    ::setsockopt(peer_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (peer_ >= 0 && shake_hands()) serve();
    edge.command(false);  // No more commands arrive, so the device becomes idle.
    force.store(0.0);
    ::close(peer_);
  }
}

/// Waits for `size` bytes or more. Returns false if no more bytes will come.
bool HaplyService::fill(std::size_t size) {
  std::array<char, 4096> room{};
  while (heard_.size() < size) {
    if (over_.load() || hangs_up.load()) return false;
    pollfd state{blocks.load() ? -1 : peer_, POLLIN, 0};
    if (::poll(&state, 1, 1) <= 0) continue;
    const ssize_t count = ::recv(peer_, room.data(), room.size(), 0);
    if (count <= 0) return false;
    heard_.append(room.data(), static_cast<std::size_t>(count));
  }
  return true;
}

bool HaplyService::shake_hands() {
  std::size_t end = 0;
  while ((end = heard_.find("\r\n\r\n")) == std::string::npos)
    if (!fill(heard_.size() + 1)) return false;
  const std::string head = heard_.substr(0, end);
  heard_.erase(0, end + 4);
  const std::string name = "Sec-WebSocket-Key: ";
  const std::size_t at = head.find(name) + name.size();
  const std::string text =
      head.substr(at, head.find('\r', at) - at) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, SHA_DIGEST_LENGTH> hash{};
  ::SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  std::array<unsigned char, 64> accept{};
  ::EVP_EncodeBlock(accept.data(), hash.data(), SHA_DIGEST_LENGTH);
  std::string reply =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: " +
      std::string(reinterpret_cast<const char*>(accept.data())) + "\r\n\r\n";
  if (!speaks) reply = "HTTP/1.1 404 Not Found\r\n\r\n";
  ::send(peer_, reply.data(), reply.size(), MSG_NOSIGNAL);
  if (speaks) answer(told(true));
  return speaks;
}

void HaplyService::serve() {
  while (fill(6)) {
    const auto byte = [this](std::size_t n) { return static_cast<unsigned char>(heard_[n]); };
    const unsigned opcode = byte(0) & 0x0FU;
    std::size_t size = byte(1) & 0x7FU, at = 2;
    if (size == 126) {
      if (!fill(8)) return;
      size = (static_cast<std::size_t>(byte(2)) << 8U) + byte(3);
      at = 4;
    }
    if ((byte(1) & 0x80U) == 0) return;  // A client must mask its frames.
    if (!fill(at + 4 + size)) return;
    std::string text = heard_.substr(at + 4, size);
    for (std::size_t n = 0; n < size; ++n)
      text[n] = static_cast<char>(static_cast<unsigned char>(text[n]) ^ byte(at + n % 4));
    heard_.erase(0, at + 4 + size);
    if (opcode == 8) return;
    if (opcode == 10) ++pongs;
    if (opcode == 1) understand(text);
  }
}

/// A command acts until the next command.
void HaplyService::understand(std::string_view text) {
  const std::string_view name = json_ == Json::v3_5 ? "\"set_cursor_force\":{\"vector\":"
                                                    : "\"set_cursor_force\":{\"values\":";
  const std::size_t at = text.find(name);
  const bool to_second = second && text.find("\"device_id\":\"0B1A\"") < at;
  const bool known =
      at != std::string_view::npos && (to_second || text.find("\"device_id\":\"049D\"") < at);
  for_second += to_second ? 1 : 0;
  if (!known) ++misunderstood;
  if (json_ == Json::v3_5 && text.find("\"profile\":{\"name\":") != std::string_view::npos)
    ++sessions;
  Three wanted{};
  if (known) {
    const std::string_view numbers = text.substr(at);
    wanted = {number_behind(numbers, "x"), number_behind(numbers, "y"),
              number_behind(numbers, "z")};
  }
  ++commands;
  for (std::size_t i = 0; i < 3; ++i) applied_[i] = gate.load() * wanted[i];
  applied_[2] += pushes.load();
  edge.tick();
  edge.command(wanted != Three{});
  // This store is last. A test that sees it may read the other values.
  force.store(std::hypot(applied_[0], applied_[1], applied_[2]));
  homed_ = !takes_one(homeless);
  answer(told(false));
  mass.advance(kCommandTick, {-applied_[1], applied_[0], applied_[2]});
}

std::string HaplyService::device(std::string_view id, bool first) const {
  const Three p = mass.sensed();
  std::string text = "{";
  if (json_ != Json::v3_0) text += "\"device_id\": \"" + std::string(id) + "\", ";
  if (first) {
    text +=
        "\"config\": {\"type\": \"inverse3\", \"device_info\": {\"id\": \"049D\", "
        "\"major_version\": 7}, "
        "\"gravity_compensation\": {\"enabled\": true, \"scaling_factor\": 1.0}, \"basis\": "
        "{\"permutation\": \"" +
        std::string(permutation) + "\"}, \"mount\": {\"position\": " + xyz(0, 0, 0) +
        ", \"rotation\": {\"w\": 1, \"x\": 0, \"y\": 0, \"z\": 0}, \"scale\": " +
        xyz(scale, scale, scale) + "}, \"handedness\": \"" + handedness + "\"";
    if (json_ == Json::v3_5)
      text += ", \"filters\": {\"force_gate\": {\"gain\": 0.3}, \"damping\": {\"scalar\": " +
              std::to_string(damping) + "}}";
    text += "}, ";
  }
  text += "\"state\": {\"cursor_velocity\": " + xyz(0, 0, 0) +
          ", \"angular_position\": {\"a0\": 0.5, \"a1\": -1e-3, \"a2\": null}";
  if (homed_) text += ", \"cursor_position\": " + xyz(p[1], kBack - p[0], kHeight + p[2]);
  text += ", \"current_cursor_force\": " + xyz(applied_[0], applied_[1], applied_[2]) +
          ", \"control_mode\": \"idle \\\"}\"}, \"status\": {\"calibrated\": " +
          (calibrated.load() ? "true" : "false") +
          ", \"ready\": " + (ready.load() ? "true" : "false") +
          ", \"power_supply\": " + (power_supply.load() ? "true" : "false") +
          ", \"in_use\": " + (in_use.load() ? "true" : "false") + "}}";
  return text;
}

std::string HaplyService::told(bool first) const {
  if (old_json) return R"({"devices": [{"id": "049D", "position": [0, 0, 0]}]})";
  std::string text = "{";
  if (json_ == Json::v3_5) text += "\"session_id\": 7, ";
  const bool keyed = json_ == Json::v3_0;
  text += keyed ? "\"inverse3\": {" : "\"inverse3\": [";
  const auto add = [&](std::string_view id) {
    if (keyed) text += "\"" + std::string(id) + "\": ";
    text += device(id, first);
  };
  if (plugged) add("049D");
  if (plugged && second) text += ", ";
  if (second) add("0B1A");
  text += keyed ? "}" : "]";
  text +=
      ", \"verse_grip\": [], \"wireless_verse_grip\": [{\"device_id\": \"61576\", \"state\": "
      "{\"buttons\": {\"a\": " +
      std::string(button.load() ? "true" : "false") +
      ", \"b\": " + std::string(second_button.load() ? "true" : "false") + ", \"c\": false}";
  if (grip_turns) {
    const double half = 0.5 * away_turn.load(), size = wrong_length ? 0.1 : 1.0;
    text += ", \"orientation\": {\"x\": 0.0, \"y\": " + std::to_string(size * std::sin(half)) +
            ", \"z\": 0.0, \"w\": " + std::to_string(size * std::cos(half)) + "}";
  }
  return text + ", \"battery_level\": 0.5}}]}";
}

void HaplyService::answer(std::string text) {
  if (takes_one(drops)) return;
  if (takes_one(late)) std::this_thread::sleep_for(std::chrono::milliseconds(30));
  if (takes_one(breaks)) text.resize(text.size() / 2);
  if (takes_one(huge)) text.insert(1, "\"filler\": \"" + std::string(200000, 'x') + "\", ");
  if (takes_one(fragments)) {
    const std::size_t third = text.size() / 3;
    send_frame(kText, text.substr(0, third));
    send_frame(kFinal | kPing, "still there?");
    send_frame(kMore, text.substr(third, third));
    send_frame(kFinal | kMore, text.substr(2 * third));
    return;
  }
  send_frame(kFinal | kText, text);
  if (takes_one(repeats)) send_frame(kFinal | kText, text);
}

void HaplyService::send_frame(unsigned head, std::string_view text) {
  std::string frame(1, static_cast<char>(head | odd_bits.load()));
  const auto put = [&](std::size_t value) { frame.push_back(static_cast<char>(value & 0xFFU)); };
  const bool masked = masks;
  const unsigned mask = masked ? 0x80U : 0U;
  if (text.size() < 126) {
    put(mask | text.size());
  } else if (text.size() < 65536) {
    put(mask | 126U), put(text.size() >> 8U), put(text.size());
  } else {
    put(mask | 127U);
    for (unsigned n = 8; n-- > 0;) put(text.size() >> (8U * n));
  }
  if (masked) frame.append(4, '\0');  // an identity key
  frame += text;
  ::send(peer_, frame.data(), frame.size(), MSG_NOSIGNAL);
}

}  // namespace stand_in
