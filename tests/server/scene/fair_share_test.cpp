// Tests how sessions share a scene's thread when time is short. The clock is simulated.

#include "server/scene/fair_share.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <utility>

#include "server/scene/load_log.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::fair_share_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A thread that answers datagrams in turn, from a socket with room for 5000.
class Thread {
 public:
  static constexpr std::size_t kRoom = 5000;
  static constexpr Nanoseconds kDropped{1000};  // [ns] cost of a dropped datagram

  explicit Thread(const Scene& scene) : sessions_(scene, 60s, 64, nullptr, {.sample_rate = 1.5}) {}

  void join(std::uint64_t id, Nanoseconds period, Nanoseconds cost) {
    SessionParameters parameters;
    parameters.servo_period = seconds(period);
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions_.answer(test::join_request(parameters), id, test::keys(id), now_)));
    clients_[id] = {.period = period, .cost = cost, .next = now_ + period};
  }

  void run(Nanoseconds time) {
    for (const Nanoseconds end = now_ + time; now_ < end;) {
      arrive();
      if (queue_.empty()) {
        now_ += 1us;
        continue;
      }
      const std::uint64_t id = queue_.front();
      queue_.pop_front();
      answer(id);
    }
  }
  /// Lets an answer of this session take `time`.
  void stall(std::uint64_t id, Nanoseconds time) {
    const Nanoseconds cost = std::exchange(clients_[id].cost, time);
    answer(id);
    clients_[id].cost = cost;
    queue_.clear();
  }
  double answered(std::uint64_t id) {
    const Client& client = clients_[id];
    return static_cast<double>(client.answered) / static_cast<double>(client.sent);
  }
  double share(std::uint64_t id) { return seconds(clients_[id].used) / seconds(now_ - 1s); }
  SceneSessions& sessions() { return sessions_; }
  void forget() {
    for (auto& [id, client] : clients_) client.sent = client.answered = 0;
  }

 private:
  struct Client {
    Nanoseconds period{}, cost{}, next{}, used{};
    std::uint64_t sent = 0, answered = 0, index = 0;
  };

  void arrive() {
    for (auto& [id, client] : clients_)
      for (; client.next <= now_; client.next += client.period) {
        ++client.sent;
        ++client.index;
        if (queue_.size() < kRoom) queue_.push_back(id);
      }
  }
  void answer(std::uint64_t id) {
    Client& client = clients_[id];
    // The session detects a lost datagram only by a gap.
    const std::uint64_t index = ++sent_[id];
    DatagramBuffer out;
    const Bytes reply =
        sessions_.receive(encoder_.samples(id, index, test::hand_batch(index)), {}, now_, out);
    const Nanoseconds cost = reply.empty() ? kDropped : client.cost;
    client.answered += reply.empty() ? 0 : 1;
    client.used += cost;
    now_ += cost;
    sessions_.spent(cost, now_);
  }

  SceneSessions sessions_;
  test::SealedEncoder encoder_{test::Way::up};
  Nanoseconds now_{1s};
  std::map<std::uint64_t, Client> clients_;
  std::map<std::uint64_t, std::uint64_t> sent_;
  std::deque<std::uint64_t> queue_;
};

constexpr std::uint64_t kGreedy = 9 << 8;

/// Ten sessions send at 1 kHz and one session at 100 kHz. Their requests take twice the thread's
/// time.
TEST(FairShare, WhoAsksForAHundredKilohertzTakesNothingFromTheOthers) {
  const Scene scene = test::room();
  Thread thread(scene);
  for (std::uint64_t n = 1; n <= 10; ++n) thread.join((100 + n) << 8, 1ms, 20us);
  thread.join(kGreedy, 10us, 20us);
  thread.run(2s);
  thread.forget();
  thread.run(2s);
  for (std::uint64_t n = 1; n <= 10; ++n) EXPECT_GT(thread.answered((100 + n) << 8), 0.99) << n;
  // The greedy session gets the rest of nine tenths: 70 % of the thread.
  EXPECT_NEAR(thread.share(kGreedy), 0.7, 0.1);
  EXPECT_GT(thread.sessions().shed(), 10'000u);
  EXPECT_EQ(thread.sessions().counters().drops[static_cast<std::size_t>(DropReason::rate)],
            thread.sessions().shed());
}

/// All sessions request more time than exists. Each must get an equal time, although their costs
/// per answer differ tenfold.
TEST(FairShare, EqualDemandGetsEqualTime) {
  const Scene scene = test::room();
  Thread thread(scene);
  thread.join(1 << 8, 1ms, 1000us);
  thread.join(2 << 8, 100us, 100us);
  thread.join(3 << 8, 1ms, 1000us);
  thread.run(4s);
  for (const std::uint64_t id : {1u << 8, 2u << 8, 3u << 8})
    EXPECT_NEAR(thread.share(id), 0.3, 0.06) << id;
}

TEST(FairShare, WhoIsAloneAndAsksForLittleLosesNothing) {
  const Scene scene = test::room();
  Thread thread(scene);
  thread.join(1 << 8, 1ms, 850us);
  thread.run(4s);
  EXPECT_EQ(thread.sessions().shed(), 0u);
}

/// An answer takes five periods. The thread must drop waiting datagrams instead of answering them
/// late.
TEST(FairShare, ASceneThatIsTooSlowAnswersTheNewest) {
  const Scene scene = test::room();
  Thread thread(scene);
  thread.join(1 << 8, 1ms, 5ms);
  thread.run(3s);
  thread.forget();
  thread.run(3s);
  EXPECT_NEAR(thread.answered(1 << 8), 0.18, 0.02);
  const FairShare::Slow slow = thread.sessions().share().slow();
  EXPECT_GE(slow.seconds, 4u);
  EXPECT_EQ(slow.interval, 1e-3);
}

TEST(FairShare, TheLevelGoesUpByWhatOthersLeave) {
  FairShare share(4);
  const auto one = share.add(1e-3), other = share.add(1e-3), idle = share.add(1e-3);
  const auto use = [&](std::uint32_t session, Nanoseconds time) {
    for (; time > 0ns; time -= 10ms) {
      share.take_up();
      share.attribute_to(session);
      share.charge(10ms);
    }
  };
  share.balance(1s);
  use(one, 10ms);
  use(other, 70ms);
  share.balance(1s + 1ms);
  EXPECT_TRUE(share.admit(other));  // 80 of 90 ms
  use(other, 30ms);
  share.balance(1s + 1ms + FairShare::kBalance);
  EXPECT_FALSE(share.admit(other));
  EXPECT_TRUE(share.admit(one));
  EXPECT_TRUE(share.admit(idle));
  // The level is 90 ms minus the time of `one`, which has decayed from 10 ms.
  EXPECT_NEAR(share.level(), 0.09 - share.used(one), 1e-9);
  // The time of an ended session must become free and must be forgotten soon.
  share.remove(other);
  share.balance(1s + 500ms);
  EXPECT_EQ(share.level(), std::numeric_limits<double>::infinity());
}

/// A forged datagram with a session's number must cost the session no time.
TEST(FairShare, WhatIsForgedIsChargedToNobody) {
  FairShare share(2);
  const auto session = share.add(1e-3);
  share.balance(1s);
  for (int n = 0; n < 100; ++n) {
    share.take_up();
    share.charge(1ms);
  }
  share.balance(1s + 1ms);
  EXPECT_EQ(share.used(session), 0.0);
  EXPECT_TRUE(share.admit(session));
}

/// Other programs stopped the thread for a second. The server must charge this time to no session.
TEST(FairShare, AStallOfTheMachineIsChargedToNobody) {
  const Scene scene = test::room();
  Thread thread(scene);
  thread.join(1 << 8, 1ms, 20us);
  thread.run(1s);
  thread.stall(1 << 8, 1s);
  thread.run(100ms);
  EXPECT_EQ(thread.sessions().shed(), 0u);
}

TEST(LoadLog, SaysAtMostOnceASecondThatAnswersAreTooSlow) {
  LoadLog log;
  FairShare::Slow slow{.seconds = 3, .answer = 5.1e-3, .interval = 1e-3};
  const auto first = log.lines(slow, 0, 10s);
  ASSERT_THAT(first, SizeIs(1));
  EXPECT_THAT(first[0], HasSubstr("an answer takes 5.1 ms on average"));
  EXPECT_THAT(first[0], HasSubstr("1 ms apart"));
  std::size_t lines = 0;
  for (int n = 1; n <= 1000; ++n) {
    slow.seconds += 2;
    lines += log.lines(slow, static_cast<std::uint64_t>(n), 10s + n * 10ms).size();
  }
  EXPECT_LE(lines, 2u * 8u);
  EXPECT_GE(lines, 8u);
}

}  // namespace
}  // namespace feltwire::fair_share_test
