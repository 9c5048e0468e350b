#pragma once

#include <asio/ip/tcp.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "protocol/crypto/tls.hpp"

namespace feltwire {

/// Asks whether a feltwire server runs there, without a token and without an entry in its counts of
/// refusals. With `wanted` it must be the server with this fingerprint. Blocks for `timeout` at
/// most. Returns why not, for people; empty: it answers.
std::optional<std::string> silence_of(const asio::ip::tcp::endpoint& server,
                                      std::chrono::milliseconds timeout,
                                      const std::optional<Fingerprint>& wanted = {});

}  // namespace feltwire
