#pragma once
// A connection to the control port of a server, for one question or for many.

#include <chrono>
#include <string>
#include <utility>
#include <variant>

#include "client/transport/false_answer.hpp"
#include "client/transport/tls_stream.hpp"
#include "protocol/crypto/secret.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

class ControlDialogue {
 public:
  /// Connects. `timeout` limits each of connecting, TLS and each answer. Throws SessionError.
  ControlDialogue(const ServerAccess& server, std::chrono::milliseconds timeout);

  /// Sends a question and returns its answer. The token goes with the first question: the server
  /// answers one after the other. Blocks. Throws SessionError, or LastingError if the same question
  /// would be refused again, or has an access token in the place of a name; the connection is of no
  /// use then.
  control::Message ask(const control::Message& question);

  /// Asks as ask() does, and returns an answer of the type Expected. Another answer is a
  /// bad_answer().
  template <class Expected>
  Expected ask_for(const control::Message& question) {
    control::Message answer = ask(question);
    auto* expected = std::get_if<Expected>(&answer);
    if (expected == nullptr) bad_answer();
    return std::move(*expected);
  }

  /// Throws SessionError: the answer makes no sense.
  [[noreturn]] void bad_answer() const;

  /// Throws FalseAnswer. `did`: what the server did that cannot be, for people, after its name.
  [[noreturn]] void refuse(const std::string& did) const;

  const TlsStream& stream() const { return stream_; }

 private:
  control::Message receive();
  /// Throws LastingError if this client and the server have no version of the protocol in common.
  void require_common_version(const ProtocolVersions& server) const;

  std::string server_;
  TlsStream stream_;
  Secret token_;
  bool let_in_ = false;
};

}  // namespace feltwire
