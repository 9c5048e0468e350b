#pragma once
// The server's end of TLS over a TCP socket. It stores little for a client that is silent.

#include <array>
#include <asio/buffer.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

struct bio_st;
struct bio_method_st;
struct ssl_st;
struct ssl_ctx_st;

namespace feltwire {

/// A stream for asio::async_read() and asio::async_write(). Asio's own ssl::stream has 100 KB of
/// buffers from its construction on. This one has none: OpenSSL reads from the socket and writes to
/// it, and is given memory only when the client's first message (ClientHello) has come whole.
///
/// A read and a write may be under way at a time. The handlers keep the owner of this alive;
/// all are called on the thread of the socket's executor. No function throws but the constructor,
/// except where Asio has no memory for a handler.
class TlsSocket {
 public:
  using executor_type = asio::ip::tcp::socket::executor_type;
  /// [bytes] of the client's first message, with the heads of its records. Browsers send less than
  /// a quarter of it.
  static constexpr std::size_t kMostHello = 8192;

  /// `socket` is connected.
  TlsSocket(asio::ip::tcp::socket socket, ssl_ctx_st& tls);
  ~TlsSocket();
  TlsSocket(const TlsSocket&) = delete;
  TlsSocket& operator=(const TlsSocket&) = delete;

  executor_type get_executor() { return socket_.get_executor(); }
  asio::ip::tcp::socket& next_layer() { return socket_; }
  /// Null until the client's first message has come.
  ssl_st* native_handle() const { return ssl_.get(); }

  /// Call it first. It fails for what is no first message of TLS, or too long.
  template <class Done>
  void async_handshake(Done done) {
    begin([this] { return shake_hands(); },
          [done = std::move(done)](const std::error_code& error, std::size_t) mutable {
            done(error);
          });
  }
  template <class Buffers, class Done>
  void async_read_some(const Buffers& buffers, Done done) {
    begin([this, into = first_of<asio::mutable_buffer>(buffers)] { return read(into); },
          std::move(done));
  }
  template <class Buffers, class Done>
  void async_write_some(const Buffers& buffers, Done done) {
    begin(
        [this, buffers] {
          const auto first = first_of<asio::const_buffer>(buffers);
          if (first.size() == asio::buffer_size(buffers)) return write(first);
          // A small first buffer and what follows it become one record.
          std::array<std::uint8_t, kTogether> room{};
          const std::size_t together = asio::buffer_copy(asio::buffer(room), buffers);
          return write(first.size() < together ? asio::buffer(room, together) : first);
        },
        std::move(done));
  }
  /// Says that nothing more is written. It does not wait for the other end to say the same.
  template <class Done>
  void async_shutdown(Done done) {
    begin([this] { return say_end(); },
          [done = std::move(done)](const std::error_code& error, std::size_t) mutable {
            done(error);
          });
  }

 private:
  static constexpr std::size_t kTogether = 1024;
  enum class Waits { for_nothing, to_read, to_write };
  /// The result of a step.
  struct Step {
    Waits waits = Waits::for_nothing;
    std::error_code error{};
    std::size_t size = 0;
  };
  struct FreeConnection {
    void operator()(ssl_st* connection) const noexcept;
  };
  struct FreeContext {
    void operator()(ssl_ctx_st* context) const noexcept;
  };

  template <class Buffer, class Buffers>
  static Buffer first_of(const Buffers& buffers) {
    const auto end = asio::buffer_sequence_end(buffers);
    for (auto at = asio::buffer_sequence_begin(buffers); at != end; ++at)
      if (const Buffer buffer(*at); buffer.size() > 0) return buffer;
    return {};
  }
  /// Tries an operation, and again whenever the socket is ready. `done` is called later.
  template <class Try, class Done>
  void begin(Try attempt, Done done) {
    const Step step = attempt();
    if (step.waits != Waits::for_nothing)
      return wait(step.waits, std::move(attempt), std::move(done));
    asio::post(get_executor(),
               [step, done = std::move(done)]() mutable { done(step.error, step.size); });
  }
  template <class Try, class Done>
  void wait(Waits waits, Try attempt, Done done) {
    socket_.async_wait(waits == Waits::to_read ? asio::ip::tcp::socket::wait_read
                                               : asio::ip::tcp::socket::wait_write,
                       [this, attempt = std::move(attempt),
                        done = std::move(done)](const std::error_code& error) mutable {
                         if (error) return done(error, 0);
                         const Step step = attempt();
                         if (step.waits != Waits::for_nothing)
                           return wait(step.waits, std::move(attempt), std::move(done));
                         done(step.error, step.size);
                       });
  }

  Step shake_hands() noexcept;
  Step await_hello();
  void drop_unread() noexcept;
  Step read(asio::mutable_buffer into) noexcept;
  Step write(asio::const_buffer from) noexcept;
  Step say_end() noexcept;
  Step outcome(int result) noexcept;
  void make_engine();

  static bio_method_st& transport();
  static int receive(bio_st* bio, char* into, int size);
  static int send(bio_st* bio, const char* from, int size);
  static long answer(bio_st* bio, int request, long number, void* data);

  asio::ip::tcp::socket socket_;
  std::unique_ptr<ssl_ctx_st, FreeContext> context_;
  std::vector<std::uint8_t> hello_;  // of it OpenSSL has read:
  std::size_t hello_read_ = 0;       // [bytes]
  std::unique_ptr<ssl_st, FreeConnection> ssl_;
};

/// How the bytes of a connection begin.
enum class FirstMessage {
  incomplete,
  whole,  // a ClientHello
  none    // something else, or a ClientHello that is longer than TlsSocket::kMostHello
};
FirstMessage first_message(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace feltwire
