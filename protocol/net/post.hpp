#pragma once
// Functions that run later in the thread of an io_context.

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <chrono>
#include <functional>
#include <new>
#include <thread>
#include <utility>

namespace feltwire {

/// Posts to `io`, which outlives the result. Throws std::bad_alloc.
inline std::function<void(std::function<void()>)> post_to(asio::io_context& io) {
  return [&io](std::function<void()> handler) { asio::post(io, std::move(handler)); };
}

/// Posts a handler that a caller waits for: a moment without memory does not lose it. Throws
/// std::bad_alloc if there is none for longer.
template <class Post, class Handler>
void post_patiently(const Post& post, const Handler& handler) {
  constexpr int kTries = 10;
  constexpr std::chrono::milliseconds kPause{1};
  for (int tries = 1;; ++tries) {
    try {
      post(handler);
      return;
    } catch (const std::bad_alloc&) {
      if (tries == kTries) throw;
      std::this_thread::sleep_for(kPause);
    }
  }
}

}  // namespace feltwire
