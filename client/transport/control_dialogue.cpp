#include "client/transport/control_dialogue.hpp"

#include <array>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/token_text.hpp"

namespace feltwire {
namespace {

/// Returns whether the server would refuse the same request again (PROTOCOL.md).
bool lasting(control::RefusalCode code) {
  using control::RefusalCode;
  return code != RefusalCode::full && code != RefusalCode::too_many &&
         code != RefusalCode::shutting_down && code != RefusalCode::failed &&
         code != RefusalCode::bad_ticket;
}

}  // namespace

ControlDialogue::ControlDialogue(const ServerAccess& server, std::chrono::milliseconds timeout)
    : server_(to_string(server.endpoint)),
      stream_(server, timeout),
      token_(server.credentials.token) {}

control::Message ControlDialogue::ask(const control::Message& question) {
  const std::vector<std::uint8_t> frame = control::encode(question);
  if (has_token({reinterpret_cast<const char*>(frame.data()), frame.size()}))
    throw LastingError(
        "a name is an access token, and names are shown and logged; nothing was sent. Give the "
        "token with --token-file, and another name");
  if (let_in_) {
    stream_.write(frame);
    return receive();
  }
  std::vector<std::uint8_t> frames = control::encode(control::Authenticate{token_});
  frames.reserve(frames.size() + frame.size());
  frames.insert(frames.end(), frame.begin(), frame.end());
  stream_.write(frames);
  wipe(frames);
  const control::Message greeting = receive();
  const auto* greeted = std::get_if<control::Authenticated>(&greeting);
  if (greeted == nullptr) bad_answer();
  require_common_version(greeted->versions);
  let_in_ = true;
  return receive();
}

void ControlDialogue::require_common_version(const ProtocolVersions& server) const {
  const ProtocolVersions ours;
  if (common_version(ours, server)) return;
  throw LastingError(server_ + " speaks " + to_string(server) +
                     " of the feltwire protocol, this client " + to_string(ours) +
                     "; install a newer " + (server.newest < ours.oldest ? "server" : "client"));
}

void ControlDialogue::bad_answer() const {
  throw SessionError(server_ +
                     " answered with something that is no feltwire message; is the port the "
                     "control port of a feltwire-server of this version?");
}

void ControlDialogue::refuse(const std::string& did) const {
  throw FalseAnswer(server_ + " " + did + "; is it a server to be trusted?");
}

control::Message ControlDialogue::receive() {
  std::array<std::uint8_t, control::kFrameLengthSize> prefix{};
  stream_.read(prefix);
  const std::size_t size = control::frame_length(prefix);
  if (size == 0 || size > control::kMaxFrame) bad_answer();
  std::vector<std::uint8_t> body(size);
  stream_.read(body);
  std::optional<control::Message> answer = control::decode(body);
  wipe(body);  // it may hold the secrets of a session
  if (!answer) bad_answer();
  if (const auto* refused = std::get_if<control::Refused>(&*answer)) {
    const std::string said = server_ + " refused: " + refused->reason;
    if (lasting(refused->code)) throw LastingError(said);
    throw SessionError(said);
  }
  return *std::move(answer);
}

}  // namespace feltwire
