#include "client/emulated_link/link.hpp"

#include <gmock/gmock.h>

#include <random>

#include "tests/support/allocation_counter.hpp"

namespace feltwire::link_test {
namespace {

using ::testing::ElementsAre;
using Milliseconds = std::chrono::milliseconds;

std::vector<std::uint8_t> datagram(std::uint8_t mark, std::size_t size = 8) {
  return std::vector<std::uint8_t>(size, mark);
}

TEST(DelayQueue, GivesByTimeAndThenAsTheyCame) {
  DelayQueue queue(8);
  EXPECT_EQ(queue.next_due(), std::nullopt);
  for (const auto& [mark, due] : {std::pair{1, 30}, {2, 10}, {3, 20}, {4, 10}, {5, 20}})
    ASSERT_TRUE(queue.push(datagram(static_cast<std::uint8_t>(mark)), Milliseconds(due), {}, 0));
  std::vector<int> order;
  while (queue.size() > 0) {
    const auto due = queue.next_due();
    const DelayQueue::Entry entry = queue.pop();
    EXPECT_EQ(entry.due, due);
    order.push_back(queue.bytes(entry)[0]);
  }
  EXPECT_THAT(order, ElementsAre(2, 4, 3, 5, 1));
}

TEST(DelayQueue, HoldsWhatItIsMadeForOverAndOver) {
  std::mt19937_64 random(5);
  DelayQueue queue(16);
  std::vector<std::pair<Nanoseconds, std::uint8_t>> model;  // sorted by departure
  for (int i = 0; i < 20'000; ++i) {
    if (random() % 2 == 0) {
      const auto mark = static_cast<std::uint8_t>(random());
      const Nanoseconds due(static_cast<std::int64_t>(random() % 50));
      ASSERT_EQ(queue.push(datagram(mark), due, {}, 0), model.size() < 16);
      if (model.size() < 16)
        model.insert(std::upper_bound(model.begin(), model.end(), due,
                                      [](Nanoseconds d, const auto& m) { return d < m.first; }),
                     {due, mark});
    } else if (queue.size() > 0) {
      const DelayQueue::Entry entry = queue.pop();
      ASSERT_EQ(entry.due, model.front().first);
      ASSERT_EQ(queue.bytes(entry)[0], model.front().second);
      model.erase(model.begin());
    }
    ASSERT_EQ(queue.size(), model.size());
  }
}

TEST(DelayQueue, LongOnesStayTooLongAndEmptyOnesEmpty) {
  DelayQueue queue(2);
  queue.push(datagram(1, 5000), Nanoseconds(1), {}, 0);
  queue.push({}, Nanoseconds(2), {}, 0);
  EXPECT_EQ(queue.bytes(queue.pop()).size(), kMaxDatagram + 1);
  EXPECT_EQ(queue.bytes(queue.pop()).size(), 0u);
}

TEST(OneWayLink, DatagramsLeaveWhenTheyAreDueUnchanged) {
  LinkOptions options;
  options.delay = 10e-3;
  OneWayLink link(options, 1, 8);
  link.enter(datagram(7, 33), Milliseconds(100));
  EXPECT_EQ(link.next_due(), Milliseconds(110));
  EXPECT_EQ(link.leave(Milliseconds(110) - Nanoseconds(1)), std::nullopt);
  const auto left = link.leave(Milliseconds(112));
  ASSERT_TRUE(left);
  EXPECT_EQ(std::vector<std::uint8_t>(left->begin(), left->end()), datagram(7, 33));
  EXPECT_EQ(link.leave(Milliseconds(112)), std::nullopt);
  const LinkStatistics s = link.statistics();
  EXPECT_EQ(s.least_delay, Milliseconds(12));  // measured delay, 2 ms above the intended delay
  EXPECT_EQ(s.greatest_delay, Milliseconds(12));
  EXPECT_EQ(s.total_delay, Milliseconds(12));
}

TEST(OneWayLink, CountsEveryDatagramOnce) {
  LinkOptions options;
  options.delay = 20e-3;
  options.jitter = 5e-3;
  options.keep_order = false;
  options.loss = 0.1;
  options.duplicate = 0.1;
  options.rate = 2.5e6;
  options.queue = 2e3;
  OneWayLink link(options, 1, 16);
  std::uint64_t left = 0;
  for (int i = 0; i < 5000; ++i) {
    // Bursts fill the queue and the memory.
    const Nanoseconds now = Milliseconds(i / 20 * 20);
    link.enter(datagram(1, 200), now);
    while (link.leave(now)) ++left;
  }
  const LinkStatistics s = link.statistics();
  EXPECT_EQ(s.entered, 5000u);
  EXPECT_EQ(s.delivered, left);
  for (const std::uint64_t n :
       {s.delivered, s.lost, s.queue_dropped, s.overflowed, s.duplicated, s.reordered})
    EXPECT_GT(n, 0u);
  EXPECT_EQ(s.entered + s.duplicated,
            s.delivered + s.lost + s.queue_dropped + s.overflowed + s.in_flight);
}

TEST(OneWayLink, ReorderedIsWhatComesAfterALaterOne) {
  LinkOptions options;
  options.delay = 10e-3;
  options.reorder = 0.1;
  options.reorder_delay = 2.5e-3;  // At 1 kHz, two later datagrams overtake the delayed datagram.
  OneWayLink link(options, 1, 64);
  std::uint64_t held = 0;
  LinkModel same(options, 1);
  constexpr int kCount = 5000;
  for (int i = 0; i < kCount + 100; ++i) {
    const Nanoseconds now = Milliseconds(i);
    if (i < kCount) {
      link.enter(datagram(1), now);
      held += same.next(8, now).arrivals[0] - now > Milliseconds(11);
    }
    while (link.leave(now)) {
    }
  }
  // A delayed datagram is overtaken unless the next two datagrams are delayed too.
  const auto reordered = static_cast<double>(link.statistics().reordered);
  EXPECT_GT(held, 400u);
  EXPECT_LE(reordered, static_cast<double>(held));
  EXPECT_GE(reordered, 0.97 * static_cast<double>(held));
  EXPECT_EQ(link.statistics().in_flight, 0u);
}

TEST(OneWayLink, ACopyIsNotReordered) {
  LinkOptions options;
  options.duplicate = 1.0;
  OneWayLink link(options, 1, 4);
  for (int i = 0; i < 10; ++i) {
    link.enter(datagram(1), Milliseconds(i));
    EXPECT_TRUE(link.leave(Milliseconds(i)));
    EXPECT_TRUE(link.leave(Milliseconds(i)));
  }
  EXPECT_EQ(link.statistics().duplicated, 10u);
  EXPECT_EQ(link.statistics().delivered, 20u);
  EXPECT_EQ(link.statistics().reordered, 0u);
}

TEST(OneWayLink, AllocatesNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer brings its own operator new";
#else
  LinkOptions options;
  options.delay = 20e-3;
  options.jitter = 5e-3;
  options.duplicate = 0.5;
  OneWayLink link(options, 1, 16);  // The capacity is small enough for an overflow.
  const auto bytes = datagram(1, 300);
  const std::size_t before = test::allocations();
  for (int i = 0; i < 10'000; ++i) {
    link.enter(bytes, Milliseconds(i));
    while (link.leave(Milliseconds(i))) {
    }
  }
  EXPECT_EQ(test::allocations() - before, 0u);
  EXPECT_GT(link.statistics().delivered, 1000u);
  EXPECT_GT(link.statistics().overflowed, 1000u);
#endif
}

TEST(TwoWayLink, IsDueWhenEitherDirectionIs) {
  TwoWayLinkOptions options;
  options.up.delay = 10e-3;
  options.down.delay = 4e-3;
  TwoWayLink link(options, 0, 4);
  EXPECT_EQ(link.next_due(), std::nullopt);
  link.up.enter(datagram(1), Milliseconds(0));
  EXPECT_EQ(link.next_due(), Milliseconds(10));
  link.down.enter(datagram(1), Milliseconds(1));
  EXPECT_EQ(link.next_due(), Milliseconds(5));
  ASSERT_TRUE(link.down.leave(Milliseconds(5)));
  EXPECT_EQ(link.next_due(), Milliseconds(10));
}

}  // namespace
}  // namespace feltwire::link_test
