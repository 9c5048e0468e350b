#pragma once
// A control port that gives the answers of a test, true or false.

#include <netinet/tcp.h>

#include <functional>
#include <mutex>
#include <vector>

#include "tests/client/peer.hpp"

namespace feltwire::testing {

/// It serves one client after another and answers at most kMost questions in all. A client that
/// would ask for ever is then noticed and ended.
class AnsweringPeer {
 public:
  static constexpr std::size_t kMost = 3000;
  using Answer = std::function<control::Message(const control::Message& question)>;

  explicit AnsweringPeer(Answer answer) : answer_(std::move(answer)) {
    ::listen(socket_.descriptor(), 8);
    thread_ = std::thread([this] { serve(); });
  }
  ~AnsweringPeer() {
    ::shutdown(socket_.descriptor(), SHUT_RDWR);
    {
      const std::lock_guard lock(mutex_);
      if (connection_ >= 0) ::shutdown(connection_, SHUT_RDWR);
      over_ = true;
    }
    thread_.join();
  }
  AnsweringPeer(const AnsweringPeer&) = delete;
  AnsweringPeer& operator=(const AnsweringPeer&) = delete;

  ServerAccess access() const { return test::access(socket_.port()); }
  /// The questions so far, except the tokens.
  std::vector<control::Message> questions() const {
    const std::lock_guard lock(mutex_);
    return questions_;
  }
  /// The questions of one kind.
  template <class Question>
  std::vector<Question> of_kind() const {
    std::vector<Question> found;
    for (const control::Message& question : questions())
      if (const auto* one = std::get_if<Question>(&question)) found.push_back(*one);
    return found;
  }

 private:
  void serve() {
    const test::TlsContext context = test::server_context(test::identity());
    for (;;) {
      const int connection = ::accept(socket_.descriptor(), nullptr, nullptr);
      if (connection < 0) return;
      LocalSocket::limit(connection);
      const int at_once = 1;  // an answer of many records else waits for acknowledgements
      ::setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
      {
        const std::lock_guard lock(mutex_);
        if (over_) ::shutdown(connection, SHUT_RDWR);
        connection_ = connection;
      }
      converse(context.get(), connection);
      const std::lock_guard lock(mutex_);
      connection_ = -1;
      ::close(connection);
    }
  }
  void converse(SSL_CTX* context, int connection) {
    test::TlsConnection tls(context, connection);
    if (!tls.accept() || !ControlPeer::read(tls)) return;
    tls.write(control::encode(control::Authenticated{"tester", "*", Role::admin}));
    while (const auto question = ControlPeer::read(tls)) {
      {
        const std::lock_guard lock(mutex_);
        questions_.push_back(*question);
        if (questions_.size() >= kMost) return;
      }
      if (!tls.write(control::encode(answer_(*question)))) return;
    }
  }

  Answer answer_;
  LocalSocket socket_{SOCK_STREAM};
  mutable std::mutex mutex_;  // guards the next members
  std::vector<control::Message> questions_;
  int connection_ = -1;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace feltwire::testing
