// Work in background threads: its result, and its end when the owner goes away.

#include "client/transport/background_work.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include "client/transport/tls_stream.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"

namespace feltwire {
namespace {

TEST(BackgroundWork, GivesItsResultOrWhatItThrew) {
  BackgroundWork<int> none;
  EXPECT_FALSE(none.valid());
  BackgroundWork<int> work([] { return 7; });
  ASSERT_TRUE(work.valid());
  test::eventually("the result", [&] { return work.is_ready(); });
  EXPECT_EQ(work.get(), 7);
  EXPECT_FALSE(work.valid());
  BackgroundWork<int> fails([]() -> int { throw std::runtime_error("no"); });
  EXPECT_THROW(fails.get(), std::runtime_error);
}

TEST(BackgroundWork, IsCancelledWhenItsOwnerGoesOrTakesOther) {
  const auto owned = std::make_shared<int>(0);
  const auto endless = [owned] {
    for (;;) {
      check_cancelled();
      std::this_thread::yield();
    }
    return 0;
  };
  BackgroundWork<int> work(endless);
  work = BackgroundWork<int>(endless);
  // This test has two: its own, and that of `endless`.
  test::eventually("the first work ends", [&] { return owned.use_count() <= 3; });
  work = {};
  test::eventually("the second work ends", [&] { return owned.use_count() == 2; });
}

/// A server that takes connections and says nothing.
class SilentServer {
 public:
  SilentServer() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(socket_, 8), 0);
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~SilentServer() { ::close(socket_); }
  SilentServer(const SilentServer&) = delete;
  SilentServer& operator=(const SilentServer&) = delete;
  ServerAccess access() const { return test::access(port_); }

 private:
  int socket_;
  std::uint16_t port_ = 0;
};

TEST(BackgroundWork, AConnectionThatWaitsForAnAnswerEndsWhenItIsCancelled) {
  const SilentServer server;
  const auto owned = std::make_shared<int>(0);
  BackgroundWork<int> work([owned, access = server.access()] {
    const TlsStream stream(access, std::chrono::hours(1));
    return 0;
  });
  work = {};
  test::eventually("the connection ends", [&] { return owned.use_count() == 1; });
}

}  // namespace
}  // namespace feltwire
