#pragma once
// Internal to client/transport: questions to a server, and its answers.

#include <chrono>
#include <string>
#include <utility>
#include <variant>

#include "client/transport/control_client.hpp"
#include "client/transport/tls_stream.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// A connection for one question after the other. It blocks and throws as join() does.
class Dialogue {
 public:
  /// `server` must outlive this.
  Dialogue(const ServerAccess& server, std::chrono::milliseconds timeout);

  /// The token goes with the first question: the server answers one after the other.
  control::Message ask(const control::Message& question);
  /// The same for an answer of one kind; another one is a bad_answer().
  template <class Expected>
  Expected ask_for(const control::Message& question) {
    control::Message answer = ask(question);
    auto* expected = std::get_if<Expected>(&answer);
    if (expected == nullptr) bad_answer();
    return std::move(*expected);
  }

  /// Throws SessionError.
  [[noreturn]] void bad_answer() const;

  const TlsStream& stream() const { return stream_; }

 private:
  control::Message receive();

  std::string server_;
  TlsStream stream_;
  const Secret& token_;
  bool let_in_ = false;
};

}  // namespace feltwire
