#pragma once

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "protocol/net/clock.hpp"

namespace feltwire {

/// Waits until the descriptor is ready for `events` (POLLIN, POLLOUT), a signal comes, or the
/// monotonic time `latest`. Returns whether it is ready, or broken.
inline bool poll_until(int descriptor, short events, Nanoseconds latest) noexcept {
  const Nanoseconds left = std::max(latest - monotonic_now(), Nanoseconds(0));
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec time{.tv_sec = static_cast<time_t>(whole.count()),
                      .tv_nsec = static_cast<long>((left - whole).count())};
  pollfd state{descriptor, events, 0};
  return ::ppoll(&state, 1, &time, nullptr) > 0;
}

}  // namespace feltwire
