#pragma once

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <chrono>
#include <new>
#include <thread>

namespace feltwire {

/// Posts a handler that a caller waits for: a moment without memory does not lose it. Throws
/// std::bad_alloc if there is none for longer.
template <class Handler>
void post_patiently(asio::io_context& io, const Handler& handler) {
  constexpr int kTries = 10;
  constexpr std::chrono::milliseconds kPause{1};
  for (int tries = 1;; ++tries) {
    try {
      asio::post(io, handler);
      return;
    } catch (const std::bad_alloc&) {
      if (tries == kTries) throw;
      std::this_thread::sleep_for(kPause);
    }
  }
}

}  // namespace feltwire
