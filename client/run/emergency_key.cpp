#include "client/run/emergency_key.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>
#include <utility>

namespace feltwire {

EmergencyKey::EmergencyKey(std::shared_ptr<EmergencyStop> stop, int keys) noexcept
    : stop_(std::move(stop)), keys_(keys) {
  termios now{};
  if (!stop_ || ::tcgetattr(keys_, &now) != 0 || ::tcgetpgrp(keys_) != ::getpgrp()) return;
  termios raw = now;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  if (::tcsetattr(keys_, TCSANOW, &raw) == 0) before_ = now;
}

EmergencyKey::~EmergencyKey() {
  if (before_) ::tcsetattr(keys_, TCSANOW, &*before_);
}

EmergencyKey::Turned EmergencyKey::take() noexcept {
  std::array<char, 64> typed{};
  const ssize_t count = ::read(keys_, typed.data(), typed.size());
  if (count <= 0) {
    // The terminal was closed. Stop reading it, because it would always be ready.
    if (count == 0 || errno != EINTR) before_.reset();
    return Turned::nothing;
  }
  const auto keys = std::span(typed).first(static_cast<std::size_t>(count));
  if (std::find(keys.begin(), keys.end(), ' ') != keys.end()) {
    stop_->press();
    return Turned::stopped;
  }
  if (std::find(keys.begin(), keys.end(), 'r') == keys.end() || !stop_->pressed())
    return Turned::nothing;
  stop_->reset();
  return Turned::started;
}

}  // namespace feltwire
