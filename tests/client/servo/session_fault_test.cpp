// Connects servo, datagrams and server in one process with a simulated clock. Applies each fault to
// a hand and its session (PROTOCOL.md, "Faults").

#include <gtest/gtest.h>
#include <netinet/in.h>

#include <functional>
#include <optional>
#include <vector>

#include "client/servo/servo.hpp"
#include "client/transport/datagram_session.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/core/support.hpp"
#include "tests/protocol/sealed.hpp"

namespace feltwire::session_fault_test {
namespace {

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
constexpr Nanoseconds kSilence = std::chrono::seconds(2);
constexpr std::uint64_t kSession = 0x700, kOther = 0x800;
constexpr int kHoldTicks = 100;  // the hold time in ticks

using Datagram = std::vector<std::uint8_t>;
/// A fault changes a datagram. An empty result means that the datagram is lost.
using Fault = std::function<Datagram(const Datagram&)>;

const Fault kNone = [](const Datagram& d) { return d; };
const Fault kCut = [](const Datagram&) { return Datagram(); };

Datagram copy(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

Scene floor_scene() {
  Object plane;
  plane.name = "floor";
  plane.shape = Plane{};
  plane.material = {.stiffness = 500.0};
  return Scene("floor", {plane});
}

/// A hand presses slowly into the floor.
struct Hand {
  DeviceSpec spec = builtin_device("simulated");
  Servo servo;
  DatagramSession datagrams;
  double z = 1e-3;
  double fastest_fall = 0.0;  // [N] largest fall from one tick to the next
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;
  std::uint64_t answers = 0, goodbyes = 0;

  Hand(std::uint64_t session, const SessionParameters& parameters)
      : servo(spec, parameters), datagrams(session, test::keys(session), parameters, false) {}

  /// Runs a tick and returns its datagram.
  Datagram tick(Nanoseconds now) {
    const double before = servo.held().force().norm();
    z = std::max(z - 1e-5, -5e-3);
    const Sample* sample =
        servo.hold(servo.render({.pose = {.position = Vec3(0.01, 0.02, z)}}, now));
    fastest_fall = std::max(fastest_fall, before - servo.held().force().norm());
    return copy(datagrams.pack(*sample));
  }
  void take(const Datagram& datagram, Nanoseconds now) {
    if (datagram.empty()) return;
    switch (datagrams.take(datagram, reply, reason)) {
      case DatagramSession::Arrival::reply:
        answers += servo.take(reply, now) ? 1 : 0;
        break;
      case DatagramSession::Arrival::goodbye:
        ++goodbyes;
        break;
      case DatagramSession::Arrival::dropped:
        break;
    }
  }
  double force() const { return servo.held().force().norm(); }
  std::uint64_t dropped(DropReason why) const {
    return datagrams.dropped()[static_cast<std::size_t>(why)];
  }
};

struct World {
  SessionParameters parameters;
  Scene scene = floor_scene();
  std::unique_ptr<SceneSessions> server = std::make_unique<SceneSessions>(scene, kSilence, 8);
  Hand hand;
  Peer peer{.address = {}, .length = sizeof(sockaddr_in)};
  DatagramBuffer reply_room;
  Nanoseconds now = std::chrono::seconds(100);
  Fault up = kNone, down = kNone;

  explicit World(BoundingSide side = BoundingSide::both)
      : parameters([side] {
          SessionParameters p;
          p.side = side;
          return p;
        }()),
        hand(kSession, parameters) {
    join(kSession);
  }
  void join(std::uint64_t id) {
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(server->answer(
        control::JoinRequest{"tester", "floor", hand.spec, parameters}, id, test::keys(id), now)));
  }
  Datagram exchange(const Datagram& datagram) {
    return datagram.empty() ? Datagram() : copy(server->receive(datagram, peer, now, reply_room));
  }
  void tick() {
    now += kPeriod;
    const Datagram answer = exchange(up(hand.tick(now)));
    if (!answer.empty()) hand.take(down(answer), now);
    for (const auto& farewell : server->expire(now)) hand.take(down(farewell.datagram), now);
  }
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) tick();
  }
  std::uint64_t drops(DropReason why) const {
    return server->counters().drops[static_cast<std::size_t>(why)];
  }
};

/// Runs a session until the hand has a force.
void press(World& world) {
  world.run(400);
  ASSERT_GT(world.hand.force(), 1.0);
  ASSERT_EQ(world.hand.answers, 400u);
  world.hand.fastest_fall = 0.0;
}

/// Replaces the newest sample's position by NaN.
Datagram with_nan(const Datagram& datagram) {
  SampleBatch batch;
  const Guarded guarded = guard(datagram, 0b1110);
  EXPECT_EQ(decode(test::opened(datagram, test::Way::up), batch), DropReason::none);
  batch.samples[0].pose.position.y() = std::nan("");
  test::SealedEncoder encoder(test::Way::up);
  return copy(encoder.samples(guarded.header.session, guarded.header.packet_number, batch));
}
Datagram changed(const Datagram& datagram, const std::function<void(Reply&)>& change) {
  Reply reply;
  const Guarded guarded = guard(datagram, 0b1110);
  EXPECT_EQ(decode(test::opened(datagram, test::Way::down), reply), DropReason::none);
  change(reply);
  test::SealedEncoder encoder(test::Way::down);
  return copy(encoder.reply(guarded.header.session, guarded.header.packet_number, reply));
}
Datagram reply_with_nan(const Datagram& datagram) {
  return changed(datagram, [](Reply& r) { r.command.frictional.x() = std::nan(""); });
}
Datagram reply_to_the_future(const Datagram& datagram) {
  return changed(datagram, [](Reply& r) { r.sample_index += 100'000; });
}

struct Case {
  const char* name;
  Fault up, down;
};
std::vector<Case> faults() {
  return {{"both ways cut", kCut, kCut},
          {"the way up cut", kCut, kNone},
          {"the way down cut", kNone, kCut},
          {"samples that are no numbers", with_nan, kNone},
          {"replies that are no numbers", kNone, reply_with_nan},
          {"replies to samples never sent", kNone, reply_to_the_future}};
}

// Without answers the force must fade within the hold time and without a step. The session must
// continue if answers return in time.
TEST(SessionFault, WithoutAnswersTheForceFadesAndASessionInTimeGoesOn) {
  for (const Case& fault : faults()) {
    for (const BoundingSide side : {BoundingSide::server, BoundingSide::both}) {
      World world(side);
      press(world);
      world.up = fault.up;
      world.down = fault.down;
      world.run(kHoldTicks / 2 - 1);
      EXPECT_GT(world.hand.force(), 1.0) << fault.name;  // The force must not end at once.
      world.run(kHoldTicks / 2 + 2);
      EXPECT_EQ(world.hand.force(), 0.0) << fault.name;
      EXPECT_LE(world.hand.fastest_fall, world.hand.spec.max_force / (0.5 * kHoldTicks) + 1e-9)
          << fault.name;
      world.run(kHoldTicks);
      EXPECT_EQ(world.hand.force(), 0.0) << fault.name;

      world.up = world.down = kNone;
      const std::uint64_t before = world.hand.answers;
      world.run(100);
      EXPECT_EQ(world.hand.answers, before + 100) << fault.name;
      EXPECT_EQ(world.hand.goodbyes, 0u) << fault.name;
      if (side == BoundingSide::both) {
        EXPECT_EQ(world.hand.servo.port().violations(), 0u);
      }
    }
  }
}

TEST(SessionFault, WhatIsDroppedIsCountedUnderItsName) {
  World world;
  press(world);
  world.up = with_nan;
  world.run(5);
  EXPECT_EQ(world.drops(DropReason::not_finite), 5u);
  world.up = kNone;
  world.down = reply_with_nan;
  world.run(5);
  EXPECT_EQ(world.hand.dropped(DropReason::not_finite), 5u);
  world.down = reply_to_the_future;
  world.run(5);
  EXPECT_EQ(world.hand.servo.statistics().replies.refused, 5u);
}

TEST(SessionFault, SilenceIsEvictedAndSaysSo) {
  World world;
  press(world);
  world.up = with_nan;  // Dropped samples must not count as signs of life.
  world.run(1999);
  EXPECT_EQ(world.server->size(), 1u);
  world.run(1);
  EXPECT_EQ(world.server->size(), 0u);
  EXPECT_EQ(world.hand.goodbyes, 1u);
  EXPECT_EQ(world.hand.reason, GoodbyeReason::evicted);
}

/// A restarted server has no record of the session. The server does not answer, and the force must
/// fade.
TEST(SessionFault, AServerThatWasStartedAnewAnswersNoOldSession) {
  World world;
  press(world);
  world.server = std::make_unique<SceneSessions>(world.scene, kSilence, 8);
  world.run(kHoldTicks + 1);
  EXPECT_EQ(world.hand.force(), 0.0);
  EXPECT_EQ(world.drops(DropReason::session), static_cast<std::uint64_t>(kHoldTicks + 1));
  // The client joins a new session. The client must continue its sample count.
  world.join(kOther);
  world.hand.datagrams.resume(kOther, test::keys(kOther));
  world.hand.servo.reconnected(true);
  const std::uint64_t before = world.hand.answers;
  world.run(50);
  EXPECT_EQ(world.hand.answers, before + 50);
}

/// A jump forwards is a gap, which counts as one long step. After a jump backwards all samples are
/// stale.
TEST(SessionFault, SampleIndicesThatJump) {
  World forward;
  press(forward);
  const auto jump = [](const Datagram& datagram, std::int64_t by) {
    SampleBatch batch;
    const Guarded guarded = guard(datagram, 0b1110);
    EXPECT_EQ(decode(test::opened(datagram, test::Way::up), batch), DropReason::none);
    for (int i = 0; i < batch.count; ++i)
      batch.samples[static_cast<std::size_t>(i)].index += static_cast<std::uint64_t>(by);
    if (batch.previous > 0) batch.previous += static_cast<std::uint64_t>(by);
    test::SealedEncoder encoder(test::Way::up);
    return copy(encoder.samples(guarded.header.session, guarded.header.packet_number, batch));
  };
  forward.up = [&](const Datagram& d) { return jump(d, 1'000'000); };
  forward.down = [](const Datagram& d) {
    return changed(d, [](Reply& r) {
      EXPECT_TRUE(r.command.finite());
      r.sample_index -= 1'000'000;
    });
  };
  forward.run(100);
  EXPECT_EQ(forward.hand.answers, 500u);
  EXPECT_EQ(forward.server->counters().samples.gaps, 1u);
  EXPECT_EQ(forward.hand.servo.port().violations(), 0u);

  World backward;
  press(backward);
  backward.up = [&](const Datagram& d) { return jump(d, -350); };
  backward.run(kHoldTicks + 1);
  EXPECT_EQ(backward.hand.force(), 0.0);
  EXPECT_EQ(backward.drops(DropReason::stale), static_cast<std::uint64_t>(kHoldTicks + 1));
  backward.run(249);  // After this run the sample count has reached its former value.
  const std::uint64_t before = backward.hand.answers;
  backward.down = [](const Datagram& d) {
    return changed(d, [](Reply& r) { r.sample_index += 350; });
  };
  backward.run(10);
  EXPECT_EQ(backward.hand.answers, before + 10);
}

/// Client times are constant, decreasing or absurd. The server's forces must be finite and no
/// larger than with correct times.
TEST(SessionFault, ClientTimesThatRunBackEarnNothing) {
  World good, bad;
  std::uint64_t n = 0;
  bad.up = [&n](const Datagram& datagram) {
    SampleBatch batch;
    const Guarded guarded = guard(datagram, 0b1110);
    EXPECT_EQ(decode(test::opened(datagram, test::Way::up), batch), DropReason::none);
    constexpr auto kLimit = std::numeric_limits<std::int64_t>::max();
    const std::int64_t times[] = {0, -5, kLimit, -kLimit, 7};
    for (int i = 0; i < batch.count; ++i)
      batch.samples[static_cast<std::size_t>(i)].client_time = Nanoseconds(times[n % 5]);
    ++n;
    test::SealedEncoder encoder(test::Way::up);
    return copy(encoder.samples(guarded.header.session, guarded.header.packet_number, batch));
  };
  for (int i = 0; i < 400; ++i) {
    good.tick();
    bad.tick();
    ASSERT_TRUE(bad.hand.servo.command().finite());
    ASSERT_LE(bad.hand.force(), good.hand.force() + 1e-9) << i;
  }
  EXPECT_EQ(bad.hand.answers, 400u);
  EXPECT_EQ(bad.hand.servo.port().violations(), 0u);
}

/// A server clock that runs backwards must not evict a session.
TEST(SessionFault, AServersClockThatRunsBackEvictsNobody) {
  World world;
  press(world);
  EXPECT_TRUE(world.server->expire(world.now - std::chrono::hours(1)).empty());
  EXPECT_EQ(world.server->size(), 1u);
}

// Two programs use one session by mistake.

/// The second program starts when the first is far ahead. The server must not answer the second,
/// and the first hand must feel no difference.
TEST(TwoOfOneSession, WhoComesLaterIsNotHeard) {
  World both, alone;
  Hand late(kSession, both.parameters);
  both.run(2000);
  alone.run(2000);
  for (int n = 0; n < 500; ++n) {
    both.tick();
    alone.tick();
    ASSERT_EQ(both.hand.servo.held(), alone.hand.servo.held());
    late.take(both.exchange(late.tick(both.now)), both.now);
    ASSERT_EQ(late.force(), 0.0);
  }
  EXPECT_EQ(late.answers, 0u);
  EXPECT_EQ(both.drops(DropReason::packet_number), 500u);
  EXPECT_EQ(both.server->counters().samples.duplicates, 500u);
}

/// Both programs start together. The server answers the earlier datagram of each number and counts
/// the later one as a duplicate. Neither hand may get more energy than its device dissipated.
TEST(TwoOfOneSession, OfTwoAtOnceTheFasterIsAnswered) {
  test::Random random(11);
  // share of the ticks in which the second program is earlier
  for (const double share : {0.0, 0.5, 1.0}) {
    World world;
    Hand second(kSession, world.parameters);
    second.z = -2e-3;  // at another depth
    std::uint64_t answered = 0;
    for (int n = 0; n < 2000; ++n) {
      world.now += kPeriod;
      Hand* hands[] = {&world.hand, &second};
      Datagram sent[] = {world.hand.tick(world.now), second.tick(world.now)};
      const int first = random.chance(share) ? 1 : 0;
      for (const int i : {first, 1 - first}) {
        const Datagram answer = world.exchange(sent[i]);
        answered += answer.empty() ? 0 : 1;
        hands[i]->take(answer, world.now);
      }
    }
    EXPECT_EQ(answered, 2000u);
    EXPECT_EQ(world.drops(DropReason::packet_number), 2000u);
    EXPECT_EQ(world.hand.answers + second.answers, 2000u);
    if (share == 0.0) {
      EXPECT_EQ(second.force(), 0.0);
    }
    if (share == 1.0) {
      EXPECT_EQ(world.hand.force(), 0.0);
    }
    EXPECT_EQ(world.hand.servo.port().violations(), 0u);
    EXPECT_EQ(second.servo.port().violations(), 0u);
  }
}

/// Two clients may have the same name. Each has a session of its own.
TEST(TwoOfOneName, AreTwoSessions) {
  World both, alone;
  both.join(kOther);  // equal name, device and scene
  Hand other(kOther, both.parameters);
  EXPECT_EQ(both.server->size(), 2u);
  for (int n = 0; n < 500; ++n) {
    both.tick();
    alone.tick();
    other.take(both.exchange(other.tick(both.now)), both.now);
    ASSERT_EQ(both.hand.servo.held(), alone.hand.servo.held());
  }
  EXPECT_EQ(other.answers, 500u);
}

}  // namespace
}  // namespace feltwire::session_fault_test
