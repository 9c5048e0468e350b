// Tests the directory on real NATS servers.

#include "server/nats_directory/nats_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/access/identity.hpp"
#include "server/fleet/ownership.hpp"
#include "server/fleet/record_codec.hpp"
#include "tests/server/fleet/directory_contract.hpp"
#include "tests/server/fleet/lying_directory.hpp"
#include "tests/server/nats_directory/nats_servers.hpp"

namespace feltwire::nats_directory_test {
namespace {

using namespace std::chrono_literals;
using test::await_value;
using test::eventually;
using test::NatsServers;
using ::testing::HasSubstr;

const HostName kA{"a", 11}, kB{"b", 22};

/// A host's knowledge of a scene, read from a watch.
struct Reader {
  SceneOwnership scene;
  std::unique_ptr<DirectoryWatch> watch;
  bool lost = false;

  void read(Nanoseconds patience = 50ms) {
    if (const auto entry = watch->next(patience))
      if (const auto record = decode_scene_record(entry->value))
        lost = see_record(scene, *record, entry->revision) || lost;
  }
};

/// Writes the owner's record until the directory has it, as an owner does.
void write_record(Directory& directory, Reader& owner) {
  eventually("the owner's record is written", [&] {
    const auto record = record_to_write(owner.scene);
    if (!record) return true;
    const auto answer =
        directory.compare_and_swap(Bucket::scenes, "room", encode(*record), owner.scene.revision);
    if (answer.result == WriteResult::written)
      finish_write(owner.scene, *record, answer.revision);
    else
      owner.read();
    return false;
  });
}

void claim_scene(Directory& directory, Reader& host, const HostName& self) {
  eventually("the scene is claimed", [&] {
    const SceneRecord record = claim(host.scene, self, {});
    const auto answer =
        directory.compare_and_swap(Bucket::scenes, "room", encode(record), host.scene.revision);
    if (answer.result == WriteResult::written)
      return finish_claim(host.scene, record, answer.revision);
    host.read();
    return false;
  });
}

TEST(NatsKeys, AnyTextIsAKey) {
  EXPECT_EQ(nats_key("room-1_A"), "room-1_A");
  EXPECT_EQ(nats_key("a.b *>=\xff"), "a=2Eb=20=2A=3E=3D=FF");
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  EXPECT_EQ(text_of_nats_key(nats_key(all)), all);
  for (const char* const wrong : {"a.b", "=", "=4", "=4x", "=ag", "a b"})
    EXPECT_EQ(text_of_nats_key(wrong), std::nullopt) << wrong;
}

TEST(NatsDirectory, IsADirectoryWithOneServer) {
  const NatsServers servers(1);
  NatsDirectory directory(servers.options());
  test::expect_compare_and_swap(directory);
  test::expect_watch(directory);
}

TEST(NatsDirectory, ALyingOneCanStandInFront) {
  const NatsServers servers(1);
  NatsDirectory truth(servers.options());
  test::LyingDirectory directory(truth);
  test::expect_compare_and_swap(directory);
  const std::uint64_t present = directory.list(Bucket::scenes)->front().revision;
  directory.lose(Bucket::scenes, 1);
  EXPECT_EQ(directory.list(Bucket::scenes)->front().value, "one");
  EXPECT_EQ(directory
                .compare_and_swap(Bucket::scenes, "swapped room", "other",
                                  directory.list(Bucket::scenes)->front().revision)
                .revision,
            present);
}

TEST(NatsDirectory, OnlyAHostOfTheFleetGetsIn) {
  const NatsServers servers(1);
  { const NatsDirectory first(servers.options()); }  // the servers are ready
  const auto refusal = [](NatsOptions options) -> std::string {
    options.open = 1s;
    try {
      const NatsDirectory directory(options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  };
  NatsOptions wrong = servers.options();
  wrong.password = Secret("guessed");
  EXPECT_THAT(refusal(wrong), HasSubstr("check the addresses, the certificates, the user"));

  const test::TemporaryFolder folder;
  const Identity stranger = make_identity({"host"});
  std::ofstream(folder / "c.pem") << stranger.certificate;
  std::ofstream(folder / "k.pem") << stranger.key.text();
  wrong = servers.options();
  wrong.certificate = folder / "c.pem";
  wrong.key = folder / "k.pem";
  EXPECT_NE(refusal(wrong), "") << "a host with a certificate of another authority";
  wrong = servers.options();
  wrong.authority = folder / "c.pem";
  EXPECT_NE(refusal(wrong), "") << "servers of another authority";
  wrong = servers.options();
  wrong.authority = folder / "missing.pem";
  EXPECT_THAT(refusal(wrong), HasSubstr("missing.pem"));
  EXPECT_EQ(refusal(servers.options()), "");
}

TEST(NatsDirectory, WhatWasWrittenOutlivesAServer) {
  NatsServers servers(1);
  NatsDirectory directory(servers.options());
  const auto watch = directory.watch(Bucket::scenes);
  test::answered_put(directory, Bucket::scenes, "room", "1");
  await_value(*watch, "room", "1");
  servers.kill(0);
  EXPECT_EQ(directory.put(Bucket::scenes, "room", "2").result, WriteResult::unknown);
  EXPECT_EQ(directory.list(Bucket::scenes), std::nullopt);
  servers.start(0);
  // Either value: a write without an answer may still be written later.
  eventually("the watch shows the room again", [&] {
    const auto entry = watch->next(50ms);
    return entry && entry->key == "room" && (entry->value == "1" || entry->value == "2");
  });
  test::answered_put(directory, Bucket::scenes, "room", "3");
  await_value(*watch, "room", "3");
}

/// The owner and the server that leads the directory die in the same moment. The standby serves
/// without waiting; the directory hears of it when it can.
TEST(NatsDirectory, ATakeoverWaitsForNoLeader) {
  NatsServers servers(3);
  NatsDirectory first(servers.options()), second(servers.options());
  Reader a{{}, first.watch(Bucket::scenes)}, b{{}, second.watch(Bucket::scenes)};
  claim_scene(first, a, kA);
  reserve_standby(a.scene, kB);
  write_record(first, a);
  eventually("the standby knows that it is", [&] {
    b.read();
    return b.scene.record.standby == kB;
  });
  std::optional<std::string> leader;
  eventually("the bucket has a leader", [&] {
    leader = first.leader(Bucket::scenes);
    return leader.has_value();
  });
  const int dead = NatsServers::number(*leader);
  servers.kill(dead);

  ASSERT_TRUE(take_over(b.scene, kB));
  EXPECT_EQ(answer_join(b.scene, {1, kA.number}), JoinAnswer::accepted);
  write_record(second, b);
  eventually("the former owner lets go", [&] {
    a.read();
    return a.lost;
  });
  EXPECT_EQ(answer_join(a.scene, {}), JoinAnswer::redirected);
  eventually("there is another leader", [&] {
    const auto now = second.leader(Bucket::scenes);
    return now && *now != *leader;
  });
  // The server comes back and has everything.
  servers.start(dead);
  reserve_standby(b.scene, kA);
  write_record(second, b);
  eventually("the watch goes on", [&] {
    a.read();
    return a.scene.record.standby == kA;
  });
}

TEST(NatsDirectory, TwoHostsNeverWinTheSameRevision) {
  const NatsServers servers(3);
  NatsDirectory first(servers.options()), second(servers.options());
  std::uint64_t revision = 0;
  for (int round = 0; round < 20; ++round) {
    WriteAnswer won;
    int wins = 0;
    for (NatsDirectory* const host : {&first, &second}) {
      WriteAnswer answer;
      eventually("an answer", [&] {
        answer = host->compare_and_swap(Bucket::scenes, "room", std::to_string(round), revision);
        return answer.result != WriteResult::unknown;
      });
      if (answer.result != WriteResult::written) continue;
      won = answer;
      ++wins;
    }
    ASSERT_EQ(wins, 1) << round;
    revision = won.revision;
  }
}

TEST(NatsDirectory, WithoutAMajorityEveryCallEnds) {
  NatsServers servers(3);
  NatsDirectory directory(servers.options());
  test::answered_put(directory, Bucket::hosts, "a", "1");
  servers.kill(0);
  servers.kill(1);
  EXPECT_EQ(directory.put(Bucket::hosts, "a", "2").result, WriteResult::unknown);
  EXPECT_EQ(directory.compare_and_swap(Bucket::scenes, "room", "1", 0).result,
            WriteResult::unknown);
  servers.kill(2);
  EXPECT_EQ(directory.put(Bucket::hosts, "a", "2").result, WriteResult::unknown);
  EXPECT_EQ(directory.list(Bucket::hosts), std::nullopt);
  EXPECT_EQ(directory.leader(Bucket::hosts), std::nullopt);
  EXPECT_EQ(directory.watch(Bucket::hosts)->next(1ms), std::nullopt);
}

}  // namespace
}  // namespace feltwire::nats_directory_test
