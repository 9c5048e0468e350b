// The checks of a received datagram, in the order of PROTOCOL.md.

#include "server/scene/datagram_gate.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/server/make_slot.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::datagram_gate_test {
namespace {

using namespace std::chrono_literals;
using test::slot_id;
using test::Way;

constexpr std::size_t kSessions = 4;

/// Two sessions: a hand with the number 1, a robot with the number 2.
struct Bench {
  explicit Bench(const SessionLimits& limits = {})
      : hand(test::make_slot(scene, 1, test::join_request(), nullptr, limits)),
        robot(test::make_slot(scene, 2, robot_request(), nullptr, limits)) {
    for (SessionSlot* slot : {hand.get(), robot.get()}) {
      slot->share = share.add(1e-3);
      EXPECT_TRUE(ids.insert(*slot));
    }
  }
  static control::JoinRequest robot_request() {
    control::JoinRequest request = test::join_request();
    request.role = Role::follower;
    return request;
  }
  std::vector<std::uint8_t> samples(std::uint64_t session, std::uint64_t number) {
    return copy(encoder.samples(session, number, test::hand_batch(number)));
  }
  std::vector<std::uint8_t> goodbye(std::uint64_t session, std::uint64_t number) {
    return copy(encoder.goodbye(session, number, GoodbyeReason::leaving));
  }
  static std::vector<std::uint8_t> copy(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

  Admitted admit(const std::vector<std::uint8_t>& datagram) {
    const std::size_t before = test::allocations();
    const Admitted admitted = gate.admit(datagram, now);
    EXPECT_EQ(test::allocations(), before);
    return admitted;
  }
  /// The reason to drop the datagram; none: it was admitted, or is counted apart.
  DropReason dropped(const std::vector<std::uint8_t>& datagram) {
    const auto before = gate.counters().drops;
    const bool admitted = admit(datagram).session != nullptr;
    for (std::size_t i = 0; i < kDropReasons; ++i)
      if (gate.counters().drops[i] != before[i]) {
        EXPECT_FALSE(admitted);
        EXPECT_EQ(gate.counters().drops[i], before[i] + 1);
        return static_cast<DropReason>(i);
      }
    return DropReason::none;
  }

  const Scene scene = test::room();
  std::unique_ptr<SessionSlot> hand, robot;
  SessionIds ids{kSessions};
  FairShare share{kSessions};
  DatagramGate gate{ids, share};
  test::SealedEncoder encoder{Way::up};
  Nanoseconds now{1s};
};

TEST(DatagramGate, AdmitsTheSamplesOfASession) {
  Bench bench;
  Admitted admitted = bench.admit(bench.samples(slot_id(1), 2));
  EXPECT_EQ(admitted.session, bench.hand.get());
  EXPECT_EQ(admitted.kind, DatagramKind::samples);
  EXPECT_TRUE(admitted.newest);
  SampleBatch batch;
  ASSERT_TRUE(bench.gate.read(admitted.payload, batch));
  EXPECT_EQ(batch.samples[0].index, 2u);
  admitted = bench.admit(bench.samples(slot_id(1), 1));
  EXPECT_EQ(admitted.session, bench.hand.get());
  EXPECT_FALSE(admitted.newest) << "it was overtaken";
  EXPECT_EQ(bench.gate.counters().datagrams, 2u);
}

TEST(DatagramGate, DropsInTheOrderOfTheProtocol) {
  Bench bench;
  const std::vector<std::uint8_t> good = bench.samples(slot_id(1), 1);
  const auto with = [&](std::size_t at, std::uint8_t value) {
    std::vector<std::uint8_t> bad = good;
    bad[at] = value;
    return bad;
  };
  EXPECT_EQ(bench.dropped({}), DropReason::size);
  EXPECT_EQ(bench.dropped(with(0, 0)), DropReason::magic);
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(3), 1)), DropReason::session);
  EXPECT_EQ(bench.dropped(with(good.size() - 1, static_cast<std::uint8_t>(good.back() ^ 1))),
            DropReason::sealed);
  EXPECT_EQ(bench.dropped(good), DropReason::none) << "the drops have changed nothing";
  EXPECT_EQ(bench.dropped(good), DropReason::packet_number);
  EXPECT_EQ(bench.hand->session.counters().duplicates, 1u);
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(2), 1)), DropReason::kind) << "robots send states";
  EXPECT_EQ(bench.gate.counters().datagrams, 7u);
}

TEST(DatagramGate, AHandSendsNoStatesOfARobot) {
  Bench bench;
  const std::vector<std::uint8_t> nothing(16);
  const auto state = [&](std::uint64_t session) {
    return Bench::copy(bench.encoder.seal({DatagramKind::follower_state, session, 1}, nothing));
  };
  EXPECT_EQ(bench.dropped(state(slot_id(1))), DropReason::kind);
  const Admitted admitted = bench.admit(state(slot_id(2)));
  EXPECT_EQ(admitted.session, bench.robot.get());
  RobotState read;
  EXPECT_FALSE(bench.gate.read(admitted.payload, read));
  EXPECT_EQ(bench.gate.counters().drops[static_cast<std::size_t>(DropReason::malformed)], 1u);
}

/// The rate does not hold up a goodbye.
TEST(DatagramGate, DropsWhatIsAboveTheRate) {
  Bench bench({.sample_rate = 2e-3});  // two samples a second
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(1), 1)), DropReason::none);
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(1), 2)), DropReason::none);
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(1), 3)), DropReason::rate);
  EXPECT_EQ(bench.admit(bench.goodbye(slot_id(1), 4)).kind, DatagramKind::goodbye);
  bench.now += 500ms;
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(1), 5)), DropReason::none);
  EXPECT_EQ(bench.gate.counters().shed, 0u);
}

/// The thread has no time left, and the hand used most of it.
TEST(DatagramGate, DropsASessionAboveItsShare) {
  Bench bench;
  DropReason last = DropReason::none;
  for (std::uint64_t n = 1; n <= 100 && last == DropReason::none; ++n) {
    last = bench.dropped(bench.samples(slot_id(1), n));
    bench.now += 10ms;
    bench.share.charge(10ms);
    bench.share.balance(bench.now);
  }
  EXPECT_EQ(last, DropReason::rate);
  EXPECT_EQ(bench.gate.counters().shed, 1u);
}

TEST(DatagramGate, ARepeatedGoodbyeIsNoFault) {
  Bench bench;
  const std::vector<std::uint8_t> goodbye = bench.goodbye(slot_id(1), 1);
  EXPECT_EQ(bench.admit(goodbye).kind, DatagramKind::goodbye);
  bench.ids.erase(slot_id(1));
  EXPECT_EQ(bench.dropped(goodbye), DropReason::none);
  EXPECT_EQ(bench.gate.counters().late_goodbyes, 1u);
  EXPECT_EQ(bench.dropped(bench.samples(slot_id(1), 2)), DropReason::session);
}

}  // namespace
}  // namespace feltwire::datagram_gate_test
