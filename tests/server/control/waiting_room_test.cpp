// The waiting room alone, with real sockets: connections wait until the test's limits let them in.

#include "server/control/waiting_room.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::waiting_room_test {
namespace {

using namespace std::chrono_literals;
using asio::ip::tcp;
using test::RawSocket;

/// A waiting room behind a listening socket. It keeps the connections that it admits.
struct Door {
  explicit Door(const TurnLimits& limits)
      : room(io, limits,
             [this](WaitingRoom::Id id, tcp::socket socket, const asio::ip::address& from) {
               if (std::exchange(fails, false)) {
                 room.judge(from, ConnectionTurns::Outcome::none);
                 throw std::runtime_error("no memory for it");
               }
               admitted.push_back(id);
               sockets.push_back(std::move(socket));
             }) {}

  /// A new client, whose connection has not arrived yet.
  std::unique_ptr<RawSocket> connect() {
    return std::make_unique<RawSocket>(SOCK_STREAM, acceptor.local_endpoint().port());
  }
  void arrive(std::unique_ptr<RawSocket>& client) {
    client = connect();
    room.arrive(acceptor.accept());
  }
  template <class Condition>
  void run_until(const char* what, Condition condition) {
    test::eventually(what, [&] {
      io.run_for(5ms);
      return condition();
    });
  }

  asio::io_context io{1};
  tcp::acceptor acceptor{io, {asio::ip::make_address("127.0.0.1"), 0}};
  std::vector<WaitingRoom::Id> admitted;
  std::vector<tcp::socket> sockets;
  bool fails = false;  // the next connection that is admitted
  WaitingRoom room;
};

constexpr TurnLimits kOneTurn{.rate = 1e-3, .burst = 1.0, .patience = 1h};

TEST(WaitingRoom, AdmitsAtOnceWhatTheBurstAllows) {
  TurnLimits limits = kOneTurn;
  limits.burst = 2.0;
  Door door(limits);
  std::unique_ptr<RawSocket> first, second, third;
  door.arrive(first);
  door.arrive(second);
  door.arrive(third);
  door.io.run_for(30ms);
  EXPECT_EQ(door.admitted, (std::vector<WaitingRoom::Id>{0, 1}));
  EXPECT_EQ(door.room.sent_away(), 0u);
}

TEST(WaitingRoom, TheTurnComesWithTime) {
  Door door({.rate = 100.0, .burst = 1.0, .patience = 1h});
  std::unique_ptr<RawSocket> first, second;
  door.arrive(first);
  door.arrive(second);
  door.run_until("the second turn", [&] { return door.admitted.size() == 2; });
  EXPECT_EQ(door.room.sent_away(), 0u);
}

TEST(WaitingRoom, ClosesAConnectionThatWaitsTooLong) {
  TurnLimits limits = kOneTurn;
  limits.patience = 20ms;
  Door door(limits);
  std::unique_ptr<RawSocket> first, second;
  door.arrive(first);
  door.arrive(second);
  door.run_until("the end of patience", [&] { return door.room.sent_away() == 1; });
  EXPECT_EQ(door.admitted.size(), 1u);
  EXPECT_TRUE(second->receive().empty());
}

TEST(WaitingRoom, AConnectionThatHasLeftTakesNoTurn) {
  Door door(kOneTurn);
  std::unique_ptr<RawSocket> gone = door.connect(), stays;
  tcp::socket socket = door.acceptor.accept();
  gone.reset();
  pollfd end{socket.native_handle(), POLLIN, 0};
  ASSERT_EQ(::poll(&end, 1, test::kPatience), 1);
  door.room.arrive(std::move(socket));
  EXPECT_TRUE(door.admitted.empty());
  door.arrive(stays);
  EXPECT_EQ(door.admitted, (std::vector<WaitingRoom::Id>{1}));
}

TEST(WaitingRoom, AnExceptionEndsOneConnectionOnly) {
  TurnLimits limits = kOneTurn;
  limits.burst = 2.0;
  Door door(limits);
  std::unique_ptr<RawSocket> first, second;
  door.fails = true;
  EXPECT_THROW(door.arrive(first), std::runtime_error);
  EXPECT_TRUE(first->receive().empty());
  door.arrive(second);
  EXPECT_EQ(door.admitted, (std::vector<WaitingRoom::Id>{1}));
}

TEST(WaitingRoom, CloseEndsAllThatWait) {
  Door door(kOneTurn);
  std::unique_ptr<RawSocket> first, second;
  door.arrive(first);
  door.arrive(second);
  door.room.close();
  EXPECT_TRUE(second->receive().empty());
  door.io.run();  // nothing is left to do
  EXPECT_EQ(door.room.sent_away(), 0u);
}

}  // namespace
}  // namespace feltwire::waiting_room_test
