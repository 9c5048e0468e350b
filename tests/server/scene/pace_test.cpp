// A scene's thread without time asks its clients for fewer datagrams. The clock is simulated.

#include "server/scene/pace.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::pace_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A thread that answers datagrams in turn, and clients that send as often as they are asked to.
class Thread {
 public:
  explicit Thread(const Scene& scene, SlowDownOrder order = {Slowed::observers, Slowed::hands})
      : sessions_(scene, 60s, 64, nullptr, {.sample_rate = 1.5, .slow_down = std::move(order)}) {}

  struct Client {
    Nanoseconds period{}, cost{}, next{};
    std::uint64_t index = 0, sent = 0, answered = 0;
    int pace = 1, slowest = 1;
    bool deaf = false;  // it goes on at its own pace
  };

  Client& join(std::uint64_t id, Nanoseconds period, Nanoseconds cost, Role role = Role::operator_,
               double hold_time = 0.1) {
    SessionParameters parameters;
    parameters.servo_period = seconds(period);
    parameters.hold_time = hold_time;
    control::JoinRequest request = test::join_request(parameters);
    request.role = role;
    EXPECT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions_.answer(request, id, test::keys(id), now_)));
    return clients_[id] = {.period = period, .cost = cost, .next = now_ + period};
  }
  void leave(std::uint64_t id) {
    sessions_.answer(control::LeaveRequest{id}, id, {}, now_);
    clients_.erase(id);
  }
  Client& client(std::uint64_t id) { return clients_.at(id); }

  void run(Nanoseconds time) {
    for (const Nanoseconds end = now_ + time; now_ < end;) {
      arrive();
      if (queue_.empty()) {
        now_ += 10us;
        continue;
      }
      const auto [id, since] = queue_.front();
      queue_.pop_front();
      if (clients_.contains(id)) answer(id, since);
      if (sessions_.pace().has_line(now_)) lines_.push_back(sessions_.pace_line(now_));
    }
  }
  /// The 99th percentile of the times from a datagram to its answer since forget().
  Nanoseconds p99() {
    EXPECT_FALSE(waits_.empty());
    const auto at = waits_.begin() + static_cast<std::ptrdiff_t>(waits_.size() * 99 / 100);
    std::ranges::nth_element(waits_, at);
    return *at;
  }
  double answered() const {
    std::uint64_t sent = 0, answered = 0;
    for (const auto& [id, client] : clients_) {
      sent += client.sent;
      answered += client.answered;
    }
    return static_cast<double>(answered) / static_cast<double>(sent);
  }
  void forget() {
    waits_.clear();
    for (auto& [id, client] : clients_) {
      client.sent = client.answered = 0;
      client.slowest = client.pace;
    }
  }
  std::vector<int> paces() const {
    std::vector<int> all;
    for (const auto& [id, client] : clients_) all.push_back(client.pace);
    return all;
  }
  const std::vector<std::string>& lines() const { return lines_; }
  SceneSessions& sessions() { return sessions_; }

 private:
  static constexpr std::size_t kRoom = 5000;    // datagrams in the socket
  static constexpr Nanoseconds kDropped{1000};  // cost of a datagram without an answer

  void arrive() {
    for (auto& [id, client] : clients_)
      for (; client.next <= now_; client.next += client.pace * client.period) {
        ++client.sent;
        if (queue_.size() < kRoom) queue_.emplace_back(id, client.next);
      }
  }
  void answer(std::uint64_t id, Nanoseconds since) {
    Client& client = clients_[id];
    ++client.index;
    DatagramBuffer out;
    const Bytes reply = sessions_.receive(
        encoder_.samples(id, client.index, test::hand_batch(client.index)), {}, now_, out);
    const Nanoseconds cost = reply.empty() ? kDropped : client.cost;
    now_ += cost;
    if (!reply.empty()) {
      ++client.answered;
      waits_.push_back(now_ - since);
      Reply said;
      EXPECT_EQ(decode(test::opened(reply, test::Way::down), said), DropReason::none);
      if (!client.deaf) client.pace = said.pace;
      client.slowest = std::max(client.slowest, client.pace);
    }
    sessions_.spent(cost, now_);
  }

  SceneSessions sessions_;
  test::SealedEncoder encoder_{test::Way::up};
  Nanoseconds now_{1s};
  std::map<std::uint64_t, Client> clients_;
  std::deque<std::pair<std::uint64_t, Nanoseconds>> queue_;
  std::vector<Nanoseconds> waits_;
  std::vector<std::string> lines_;
};

constexpr std::uint64_t id(std::uint64_t number) { return number << 8; }

/// Twenty hands ask for twice the time that there is.
void add_twice_the_load(Thread& thread) {
  for (std::uint64_t n = 1; n <= 20; ++n) thread.join(id(n), 1ms, 90us);
}

TEST(Pace, TwiceTheLoadIsAnsweredInTimeOnceTheClientsSendLess) {
  const Scene scene = test::room();
  Thread shed(scene, {}), slowed(scene);
  for (Thread* thread : {&shed, &slowed}) {
    add_twice_the_load(*thread);
    thread->run(4s);
    thread->forget();
    thread->run(2s);
  }
  EXPECT_LT(shed.answered(), 0.6) << "without a pace every second datagram is lost";
  EXPECT_GT(slowed.answered(), 0.999);
  EXPECT_LT(slowed.p99(), 2ms);
  EXPECT_THAT(slowed.lines(),
              ::testing::Contains(HasSubstr("of 20 sessions are asked for fewer datagrams")));
  EXPECT_GT(slowed.sessions().counters().slowed, 0u);
  EXPECT_EQ(shed.sessions().counters().slowed, 0u);
}

TEST(Pace, WhoNeedsLittleKeepsItsRate) {
  const Scene scene = test::room();
  Thread thread(scene);
  for (std::uint64_t n = 1; n <= 10; ++n) thread.join(id(n), 1ms, 20us);
  thread.join(id(99), 100us, 150us);  // asks for one and a half times the thread
  thread.run(4s);
  for (std::uint64_t n = 1; n <= 10; ++n) EXPECT_EQ(thread.client(id(n)).slowest, 1) << n;
  EXPECT_GE(thread.client(id(99)).pace, 4);
  thread.forget();
  thread.run(2s);
  EXPECT_GT(thread.answered(), 0.999);
}

/// A client that does not obey loses its own datagrams, and no other's.
TEST(Pace, WhoDoesNotObeyTakesNothingFromTheOthers) {
  const Scene scene = test::room();
  Thread thread(scene);
  for (std::uint64_t n = 1; n <= 10; ++n) thread.join(id(n), 1ms, 20us);
  thread.join(id(99), 100us, 150us).deaf = true;
  thread.run(4s);
  thread.forget();
  thread.run(2s);
  for (std::uint64_t n = 1; n <= 10; ++n) {
    const Thread::Client& client = thread.client(id(n));
    EXPECT_EQ(client.slowest, 1) << n;
    EXPECT_GT(static_cast<double>(client.answered), 0.99 * static_cast<double>(client.sent)) << n;
  }
}

TEST(Pace, ObserversAreSlowedDownBeforeHands) {
  const Scene scene = test::room();
  const auto run = [&](SlowDownOrder order) {
    Thread thread(scene, std::move(order));
    thread.join(id(1), 1ms, 300us);                                                         // 30 %
    for (std::uint64_t n = 2; n <= 3; ++n) thread.join(id(n), 1ms, 400us, Role::observer);  // 80 %
    thread.run(4s);
    return thread.paces();
  };
  const std::vector<int> observers_first = run({Slowed::observers, Slowed::hands});
  EXPECT_EQ(observers_first[0], 1);
  EXPECT_GT(observers_first[1], 1);
  EXPECT_GT(observers_first[2], 1);
  EXPECT_THAT(run({}), ElementsAre(1, 1, 1));
  const std::vector<int> hands_only = run({Slowed::hands});
  EXPECT_EQ(hands_only[1], 1);
  EXPECT_EQ(hands_only[2], 1);
}

TEST(Pace, GoesBackStepByStepWhenThereIsTimeAgain) {
  const Scene scene = test::room();
  Thread thread(scene);
  add_twice_the_load(thread);
  thread.run(3s);
  EXPECT_THAT(thread.paces(), ::testing::Each(::testing::Gt(1)));
  for (std::uint64_t n = 5; n <= 20; ++n) thread.leave(id(n));
  thread.run(30s);
  EXPECT_THAT(thread.paces(), ::testing::Each(1));
  EXPECT_THAT(thread.lines().back(), HasSubstr("as at their start again"));
}

/// Load that comes back with each step back: the steps become rare.
TEST(Pace, DoesNotSwing) {
  const Scene scene = test::room();
  Thread thread(scene);
  // At half the rate the load is just low enough for a step back, and too high after it.
  for (std::uint64_t n = 1; n <= 8; ++n) thread.join(id(n), 1ms, 118us);
  thread.run(4s);
  const std::uint64_t before = thread.sessions().counters().slowed;
  thread.run(120s);
  EXPECT_LE(thread.sessions().counters().slowed - before, 6u * 8u);
}

TEST(Pace, AShortBurstChangesNothing) {
  const Scene scene = test::room();
  Thread thread(scene);
  add_twice_the_load(thread);
  thread.run(150ms);
  for (std::uint64_t n = 5; n <= 20; ++n) thread.leave(id(n));
  thread.run(2s);
  EXPECT_EQ(thread.sessions().counters().slowed, 0u);
  EXPECT_THAT(thread.lines(), IsEmpty());
}

/// A datagram every 10 ms, and four in the hold time, are the least.
TEST(Pace, HasASlowestOne) {
  const Scene scene = test::room();
  Thread thread(scene);
  thread.join(id(1), 1ms, 3ms);
  thread.join(id(2), 4ms, 12ms);
  thread.join(id(3), 1ms, 3ms, Role::operator_, 0.02);
  thread.run(20s);
  EXPECT_THAT(thread.paces(), ElementsAre(8, 2, 4));
}

TEST(Pace, TheOrderIsReadFromAText) {
  EXPECT_THAT(slow_down_order("observers,hands"), ElementsAre(Slowed::observers, Slowed::hands));
  EXPECT_THAT(slow_down_order("hands,observers"), ElementsAre(Slowed::hands, Slowed::observers));
  EXPECT_THAT(slow_down_order("hands"), ElementsAre(Slowed::hands));
  EXPECT_THAT(slow_down_order("off"), IsEmpty());
  for (const char* wrong : {"", "hand", "hands,", ",hands", "hands,hands", "off,hands", "Hands"})
    EXPECT_THROW(slow_down_order(wrong), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace feltwire::pace_test
