#include "server/scene/scene_sessions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <limits>
#include <set>
#include <string>

#include "tests/protocol/parameter_changes.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::scene_sessions_test {
namespace {

using namespace std::chrono_literals;
using test::hand_batch;
using test::join_request;

constexpr std::uint64_t kId = 0x1234567800ull;

class SceneSessionsTest : public ::testing::Test {
 protected:
  Scene scene = test::room();
  // With this limit the tests need not wait for the sample rate.
  static inline const SessionLimits kFast{.sample_rate = 1e6};
  SceneSessions sessions{scene, 2s, 2, nullptr, kFast};
  test::SealedEncoder client{test::Way::up};
  DatagramBuffer out;
  Peer peer{.address = {}, .length = sizeof(sockaddr_in)};
  std::uint64_t packet = 0;

  void join(std::uint64_t id, Nanoseconds now = 0s) {
    const auto answer = sessions.answer(join_request(), id, test::keys(id), now);
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
    EXPECT_EQ(std::get<control::JoinAccepted>(answer).session, id);
  }
  Bytes send(const SampleBatch& batch, std::uint64_t id = kId, Nanoseconds now = 0s) {
    return sessions.receive(client.samples(id, ++packet, batch), peer, now, out);
  }
  std::uint64_t drops(DropReason reason) {
    return sessions.counters().drops[static_cast<std::size_t>(reason)];
  }
  control::RefusalCode refusal(const control::Message& request, std::uint64_t id = 99 << 8) {
    return std::get<control::Refused>(sessions.answer(request, id, test::keys(id), 0s)).code;
  }
};

TEST_F(SceneSessionsTest, SampleIsAnswered) {
  join(kId);
  const Bytes answer = send(hand_batch(3));
  const Guarded guarded = guard(answer, test::kAllKinds);
  ASSERT_EQ(guarded.drop, DropReason::none);
  EXPECT_EQ(guarded.header.kind, DatagramKind::reply);
  EXPECT_EQ(guarded.header.session, kId);
  EXPECT_EQ(guarded.header.packet_number, 1u);
  Reply reply;
  ASSERT_EQ(decode(test::opened(answer, test::Way::down), reply), DropReason::none);
  EXPECT_EQ(reply.sample_index, 3u);
}

/// The test corrects a datagram with every fault in the documented order. Each fault must be
/// counted once, and only the correct datagram may get an answer.
TEST_F(SceneSessionsTest, FaultsAreCountedInTheOrderOfTheProtocol) {
  join(kId);
  send(hand_batch(5));  // This is packet 1, so number 1 is used.

  std::vector<std::uint8_t> bytes(kMaxDatagram + 1, 0xff);
  const auto expect = [&](DropReason reason) {
    const std::uint64_t before = drops(reason);
    EXPECT_TRUE(sessions.receive(bytes, peer, 0s, out).empty());
    EXPECT_EQ(drops(reason), before + 1) << name(reason);
  };
  expect(DropReason::size);
  bytes.resize(200);
  expect(DropReason::magic);
  bytes[0] = 'F', bytes[1] = 'W';
  expect(DropReason::version);
  bytes[2] = 1;
  expect(DropReason::kind);
  bytes[3] = 2;  // A server receives no replies.
  expect(DropReason::kind);
  bytes[3] = 1;
  expect(DropReason::reserved);
  for (std::size_t i = 4; i < 8; ++i) bytes[i] = 0;
  expect(DropReason::session);
  write_header(bytes, {DatagramKind::samples, kId, 1});
  expect(DropReason::packet_number);
  write_header(bytes, {DatagramKind::samples, kId, 0});
  expect(DropReason::packet_number);
  write_header(bytes, {DatagramKind::samples, kId, 2});
  expect(DropReason::sealed);
  const Bytes unsound = client.seal({DatagramKind::samples, kId, 2}, bytes);
  bytes.assign(unsound.begin(), unsound.end());
  expect(DropReason::malformed);

  // With a valid envelope, each batch still has all later faults.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SampleBatch batch = hand_batch(5, 2);
  batch.samples[1].index = 9;
  batch.samples[2].pose.position.x() = nan;
  const auto expect_batch = [&](DropReason reason) {
    const Bytes sent = client.samples(kId, 10 + ++packet, batch);
    bytes.assign(sent.begin(), sent.end());
    expect(reason);
  };
  batch.count = 0;
  expect_batch(DropReason::count);
  batch.count = 3;
  expect_batch(DropReason::order);
  batch.samples[1].index = 4;
  expect_batch(DropReason::not_finite);
  batch.samples[2].pose.position.x() = 0;
  expect_batch(DropReason::stale);
  batch = hand_batch(6, 2);
  EXPECT_FALSE(sessions.receive(client.samples(kId, 100, batch), peer, 0s, out).empty());

  std::uint64_t dropped = 0;
  const SceneCounters counters = sessions.counters();
  for (const std::uint64_t count : counters.drops) dropped += count;
  EXPECT_EQ(counters.datagrams, dropped + 2);
  EXPECT_EQ(counters.samples.replies, 2u);
}

TEST_F(SceneSessionsTest, ReorderedPacketsAreTakenOnce) {
  join(kId);
  EXPECT_FALSE(sessions.receive(client.samples(kId, 5, hand_batch(5)), peer, 0s, out).empty());
  EXPECT_TRUE(sessions.receive(client.samples(kId, 4, hand_batch(4)), peer, 0s, out).empty());
  EXPECT_EQ(drops(DropReason::stale), 1u);
  EXPECT_TRUE(sessions.receive(client.samples(kId, 5, hand_batch(9)), peer, 0s, out).empty());
  EXPECT_EQ(drops(DropReason::packet_number), 1u);
  EXPECT_EQ(sessions.counters().samples.duplicates, 2u);
}

TEST_F(SceneSessionsTest, SilenceEndsASession) {
  join(kId, 10s);
  join(kId + 256, 10s);
  send(hand_batch(1), kId, 11s);
  EXPECT_TRUE(sessions.expire(11s).empty());
  auto goodbyes = sessions.expire(12s);  // The second session sent nothing since its join.
  ASSERT_EQ(goodbyes.size(), 1u);
  EXPECT_EQ(goodbyes[0].to.length, 0u);
  EXPECT_EQ(sessions.size(), 1u);
  // A dropped datagram must not count as a sign of life.
  send(hand_batch(1), kId, 12900ms);
  EXPECT_TRUE(sessions.expire(12999ms).empty());
  goodbyes = sessions.expire(13s);
  ASSERT_EQ(goodbyes.size(), 1u);
  EXPECT_EQ(goodbyes[0].to.length, sizeof(sockaddr_in));
  GoodbyeReason reason = GoodbyeReason::leaving;
  ASSERT_EQ(decode(test::opened(goodbyes[0].datagram, test::Way::down), reason), DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::evicted);
  EXPECT_EQ(sessions.size(), 0u);
  EXPECT_EQ(sessions.counters().silent, 2u);
  // Samples of ended sessions must still count.
  EXPECT_EQ(sessions.counters().samples.samples, 1u);
  send(hand_batch(2), kId, 13s);
  EXPECT_EQ(drops(DropReason::session), 1u);
}

TEST_F(SceneSessionsTest, GoodbyeEndsASession) {
  join(kId);
  send(hand_batch(1));
  EXPECT_TRUE(sessions.receive(client.goodbye(kId, ++packet, GoodbyeReason::leaving), peer, 0s, out)
                  .empty());
  EXPECT_EQ(sessions.size(), 0u);
  EXPECT_EQ(sessions.counters().left, 1u);
  join(kId + 256);  // A slot is free again.
  join(kId + 512);
}

TEST_F(SceneSessionsTest, ShutDownTellsEveryone) {
  join(kId);
  join(kId + 256);
  send(hand_batch(1));
  const auto goodbyes = sessions.shut_down();
  ASSERT_EQ(goodbyes.size(), 2u);
  GoodbyeReason reason = GoodbyeReason::leaving;
  ASSERT_EQ(decode(test::opened(goodbyes[0].datagram, test::Way::down), reason), DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::shutting_down);
  EXPECT_EQ(sessions.size(), 0u);
}

TEST_F(SceneSessionsTest, RequestsThatCannotBeAreRefused) {
  using control::RefusalCode;
  auto request = join_request();
  request.device.max_force = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(request), RefusalCode::bad_device);
  request = join_request();
  request.parameters.redundancy = 20;
  EXPECT_EQ(refusal(request), RefusalCode::bad_parameters);
  request = join_request();
  // The value is above this device's b/T. The check needs both values.
  request.parameters.c2 = 1e8;
  EXPECT_EQ(refusal(request), RefusalCode::bad_parameters);
  EXPECT_EQ(sessions.size(), 0u);
  // The answer to an unknown method must name the known methods.
  request = join_request();
  request.parameters.mode = "no_such_method";
  const auto unknown = sessions.answer(request, kId, test::keys(kId), 0s);
  ASSERT_TRUE(std::holds_alternative<control::Refused>(unknown));
  EXPECT_EQ(std::get<control::Refused>(unknown).code, RefusalCode::bad_parameters);
  EXPECT_THAT(std::get<control::Refused>(unknown).reason,
              ::testing::AllOf(::testing::HasSubstr("'no_such_method'"),
                               ::testing::HasSubstr(" per_axis_projected contact_frame "),
                               ::testing::HasSubstr(" energy_tank")));
  EXPECT_EQ(sessions.size(), 0u);

  EXPECT_EQ(refusal(control::LeaveRequest{kId}), RefusalCode::unknown_session);
  EXPECT_EQ(refusal(control::SetParameters{kId, {}}), RefusalCode::unknown_session);
  EXPECT_EQ(refusal(control::Left{kId}), RefusalCode::malformed);
  join(kId);
  SessionParameters slower;
  slower.servo_period = 2e-3;
  EXPECT_EQ(refusal(control::SetParameters{kId, slower}), RefusalCode::bad_parameters);
  EXPECT_EQ(refusal(join_request(), kId), RefusalCode::full);  // The id exists already.
  join(kId + 256);
  EXPECT_EQ(refusal(join_request()), RefusalCode::full);
}

TEST_F(SceneSessionsTest, ALineGrantsNoMoreThanItHasRoomFor) {
  const NetworkProfile& thin = network_profile("thin");
  SceneSessions behind{scene, 2s, 2, &thin};
  const auto answer = behind.answer(join_request(), kId, test::keys(kId), 0s);
  ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
  const SessionParameters wanted = join_request().parameters;
  EXPECT_EQ(std::get<control::JoinAccepted>(answer).parameters, over(thin, wanted));
  EXPECT_EQ(behind.find(kId)->parameters(), over(thin, wanted));
  SessionParameters impossible;
  impossible.redundancy = 20;
  EXPECT_EQ(std::get<control::Refused>(
                behind.answer(join_request(impossible), kId + 256, test::keys(kId + 256), 0s))
                .code,
            control::RefusalCode::bad_parameters);
}

TEST_F(SceneSessionsTest, ParametersChangeAndSessionsLeave) {
  SessionParameters parameters = join_request().parameters;
  parameters.side = BoundingSide::server;
  sessions.answer(join_request(parameters), kId, test::keys(kId), 0s);
  parameters.mode = "per_axis";
  parameters.velocity_cutoff = 50.0;
  const auto set = sessions.answer(control::SetParameters{kId, parameters}, 0, {}, 0s);
  EXPECT_EQ(std::get<control::ParametersSet>(set).parameters, parameters);
  EXPECT_EQ(sessions.find(kId)->parameters(), parameters);
  const auto left = sessions.answer(control::LeaveRequest{kId}, 0, {}, 0s);
  EXPECT_EQ(std::get<control::Left>(left).session, kId);
  EXPECT_EQ(sessions.find(kId), nullptr);
}

// In an earlier version, such a change got an answer but had no effect at the client.
TEST_F(SceneSessionsTest, WhatAClientActsOnDoesNotChangeBehindItsBack) {
  std::uint64_t id = 0x100;
  std::size_t changed = 0;
  for (const auto& change : test::parameter_changes()) {
    SceneSessions one(scene, 2s, 1);
    ++id;
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        one.answer(join_request(change.asked), id, test::keys(id), 0s)))
        << change.field;
    const auto answer = one.answer(control::SetParameters{id, change.granted}, 0, {}, 0s);
    const bool servers_alone = change.field == "velocity_cutoff";
    changed += servers_alone ? 1 : 0;
    EXPECT_EQ(std::holds_alternative<control::ParametersSet>(answer), servers_alone)
        << change.field;
    EXPECT_EQ(one.find(id)->parameters(), servers_alone ? change.granted : change.asked);
    const auto* refused = std::get_if<control::Refused>(&answer);
    if (refused == nullptr) continue;
    // A client must allow a new bounding method at its join. Otherwise the server must refuse the
    // change.
    if (change.field == "mode" || change.field == "projection" || change.field == "storage") {
      EXPECT_EQ(refused->code, control::RefusalCode::not_supported);
      EXPECT_THAT(refused->reason, ::testing::HasSubstr("its client takes no other law"));
      continue;
    }
    EXPECT_EQ(refused->code, control::RefusalCode::bad_parameters);
    EXPECT_THAT(refused->reason,
                ::testing::AllOf(::testing::StartsWith(change.field + ": in force "),
                                 ::testing::HasSubstr("leave and join again")));
  }
  EXPECT_EQ(changed, 1u);
}

// If only the server bounds, an admin may change the bound.
TEST_F(SceneSessionsTest, TheServersOwnBoundChangesWhileASessionRuns) {
  const std::set<std::string> bound = {
      "mode", "projection", "storage", "operator_damping", "velocity_cutoff", "reference"};
  std::size_t changed = 0;
  for (auto change : test::parameter_changes()) {
    if (!bound.contains(change.field)) continue;
    ++changed;
    change.asked.side = change.granted.side = BoundingSide::server;
    SceneSessions one(scene, 2s, 1);
    one.answer(join_request(change.asked), kId, test::keys(kId), 0s);
    const auto answer = one.answer(control::SetParameters{kId, change.granted}, 0, {}, 0s);
    ASSERT_TRUE(std::holds_alternative<control::ParametersSet>(answer)) << change.field;
    EXPECT_EQ(one.find(kId)->parameters(), change.granted);
  }
  EXPECT_GE(changed, bound.size());
}

TEST_F(SceneSessionsTest, ClientsDoNotFeelEachOther) {
  join(kId);
  join(kId + 256);
  SceneSessions alone(scene, 2s, 2, nullptr, kFast);
  ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
      alone.answer(join_request(), kId, test::keys(kId), 0s)));
  test::Generator random(1);
  test::SealedEncoder second{test::Way::up};
  for (std::uint64_t n = 1; n <= 500; ++n) {
    const Bytes sent = client.samples(kId, n, hand_batch(n, 2));
    const Bytes together = sessions.receive(sent, peer, 0s, out);
    const std::vector<std::uint8_t> copy(together.begin(), together.end());
    const Bytes apart = alone.receive(sent, peer, 0s, out);
    ASSERT_TRUE(std::equal(copy.begin(), copy.end(), apart.begin(), apart.end()));
    SampleBatch other = hand_batch(n);
    other.samples[0].pose.position = test::vector(random, 0.05);
    sessions.receive(second.samples(kId + 256, n, other), peer, 0s, out);
  }
}

/// Fuzzed datagrams must not end, stop or change the neighbouring session.
TEST_F(SceneSessionsTest, FuzzedDatagramsAreOnlyCounted) {
  join(kId);
  join(kId + 256);
  test::Generator random(2);
  test::SealedEncoder hostile{test::Way::up};
  for (std::uint64_t n = 1; n <= 3000; ++n) {
    const Bytes valid = hostile.samples(kId + 256, n, test::random_batch(random, n + 9, 3, n % 2));
    std::vector<std::uint8_t> bytes(valid.begin(), valid.end());
    for (int flips = 0; flips < 3; ++flips)
      bytes[16 + random() % (bytes.size() - 16)] = static_cast<std::uint8_t>(random());
    sessions.receive(bytes, peer, 0s, out);
    ASSERT_FALSE(send(hand_batch(n, 1)).empty());
  }
  const SceneCounters counters = sessions.counters();
  std::uint64_t dropped = 0;
  for (const std::uint64_t count : counters.drops) dropped += count;
  EXPECT_EQ(counters.datagrams, dropped + counters.samples.replies);
  EXPECT_GT(dropped, 1000u);
}

TEST_F(SceneSessionsTest, DatagramsDoNotAllocate) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  join(kId);
  send(hand_batch(1));
  const std::size_t before = test::allocations();
  for (std::uint64_t n = 2; n <= 10'000; ++n) {
    const Bytes sent = client.samples(kId, n, hand_batch(n, 3));
    sessions.receive(sent, peer, 0s, out);
    sessions.receive(sent, peer, 0s, out);  // a duplicate
    // a truncated datagram
    sessions.receive(sent.first(sent.size() - n % sent.size()), peer, 0s, out);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(sessions.counters().samples.replies, 10'000u);
}

}  // namespace
}  // namespace feltwire::scene_sessions_test
