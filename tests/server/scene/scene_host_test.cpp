// A scene's thread must divide its time between datagrams and the requests of other threads.

#include "server/scene/scene_host.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <asio/io_context.hpp>
#include <memory>

#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::scene_host_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kId = 0x100;
constexpr std::uint64_t kDatagrams = 100;  // more datagrams than a batch holds

/// A host with a joined session. The socket holds a hundred samples before the start.
struct Crowded {
  explicit Crowded(std::function<Nanoseconds()> clock, Nanoseconds busy_poll = 0ns) {
    SceneHostOptions options;
    options.address = asio::ip::make_address("127.0.0.1");
    options.silence_timeout = 100s;
    options.clock = std::move(clock);
    options.busy_poll = busy_poll;
    host = std::make_unique<SceneHost>(test::room(), options);
    host->ask(test::join_request(), kId, test::keys(kId), io, [](const control::Message&) {});
    socket = std::make_unique<test::RawSocket>(SOCK_DGRAM, host->port());
    test::SealedEncoder encoder(test::Way::up);
    for (std::uint64_t n = 1; n <= kDatagrams; ++n)
      socket->send(encoder.samples(kId, n, test::hand_batch(n)));
  }
  SceneCounters counters() const { return host->summary().counters; }

  asio::io_context io{1};
  std::unique_ptr<SceneHost> host;
  std::unique_ptr<test::RawSocket> socket;
};

/// A request that is posted during a batch must wait for a single answer instead of the batch. The
/// server's end in a slow scene must also wait for a single answer only.
TEST(SceneHost, WhatIsPostedWaitsForOneAnswer) {
  for (const Nanoseconds busy_poll : {Nanoseconds(0), Nanoseconds(1ms)}) {
    SceneHost* host = nullptr;
    int looks = 0;
    Crowded crowded(
        [&] {
          // The join reads the clock first. At the second reading, the batch has been read.
          if (++looks == 2) host->evict(kId);
          return monotonic_now();
        },
        busy_poll);
    host = crowded.host.get();
    host->start();
    ASSERT_TRUE(test::becomes([&] { return crowded.counters().datagrams == kDatagrams; }));
    EXPECT_LE(crowded.counters().samples.samples, 1u);
    EXPECT_EQ(crowded.counters().evicted, 1u);
    host->stop();
  }
}

/// The rest of the batch must be answered after the posted request.
TEST(SceneHost, NothingOfABatchIsLost) {
  SceneHost* host = nullptr;
  int looks = 0;
  Crowded crowded([&] {
    if (++looks % 3 == 2) host->evict(kId + 1);  // an unknown session
    return looks * 1us;
  });
  host = crowded.host.get();
  host->start();
  for (std::uint64_t n = 1; n <= kDatagrams; ++n)
    ASSERT_FALSE(crowded.socket->receive().empty()) << n;
  EXPECT_EQ(crowded.counters().samples.replies, kDatagrams);
  host->stop();
}

/// Every answer takes a long time on this clock. The thread reads the clock for each answer, and
/// timers run in between.
TEST(SceneHost, AnswersAllOfASlowScene) {
  Nanoseconds now{0};
  Crowded crowded([&] { return now += 10ms; });
  crowded.host->start();
  ASSERT_TRUE(test::becomes([&] { return crowded.counters().datagrams == kDatagrams; }));
  const SceneCounters counters = crowded.counters();
  EXPECT_GT(counters.samples.replies, 0u);
  // On this clock the session uses the complete thread. A tenth of the samples is therefore
  // dropped.
  EXPECT_EQ(counters.samples.replies + counters.shed, kDatagrams);
  crowded.host->stop();
}

}  // namespace
}  // namespace feltwire::scene_host_test
