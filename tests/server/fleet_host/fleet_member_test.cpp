// The knowledge of the hosts of a fleet, by the test's clock: a directory in memory, and no thread.

#include "server/fleet_host/fleet_member.hpp"

#include <gmock/gmock.h>

#include "server/fleet/memory_directory.hpp"
#include "server/fleet/record_codec.hpp"

namespace feltwire::fleet_member_test {
namespace {

using namespace std::chrono_literals;
using control::Redirected;
using control::RefusalCode;
using control::Refused;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Seat = FleetMember::Seat;
using Answer = FleetMember::Answer;

constexpr std::chrono::sys_seconds kDate{std::chrono::seconds(1'800'000'000)};

/// A host with the scene "room", and its agent's work done by hand.
struct Host {
  FleetMember member;
  std::unique_ptr<DirectoryWatch> hosts, scenes, wishes;

  Host(Directory& directory, const std::string& name, HostNumber number, std::uint16_t port)
      : member(about(name, number, port), {{"room", {}}},
               SigningKeys(paseto::SigningKey::random())),
        hosts(directory.watch(Bucket::hosts)),
        scenes(directory.watch(Bucket::scenes)),
        wishes(directory.watch(Bucket::wishes)) {}

  static HostRecord about(const std::string& name, HostNumber number, std::uint16_t port) {
    HostRecord record;
    record.host = {name, number};
    record.addresses = {"10.0.0.1", "fd00::1"};
    record.control_port = port;
    record.version = "test";
    return record;
  }
  void read(Nanoseconds now) {
    while (const auto entry = hosts->next(0ns)) member.see(Bucket::hosts, *entry, now);
    while (const auto entry = scenes->next(0ns)) member.see(Bucket::scenes, *entry, now);
    while (const auto entry = wishes->next(0ns)) member.see(Bucket::wishes, *entry, now);
  }
  void beat(Directory& directory, Nanoseconds now) {
    const HostRecord record = member.heartbeat({.hands = 1, .free_shares = {50}});
    directory.put(Bucket::hosts, record.host.name, encode(record));
    member.heard(now);
  }
  void write(Directory& directory, Nanoseconds now) {
    for (const FleetMember::Write& write : member.writes(now, 7))
      member.finish(write, directory.compare_and_swap(Bucket::scenes, write.scene,
                                                      encode(write.record), write.revision));
  }
  FleetMember::Join join(const Epoch& seen = {}, std::string_view ticket = {}) const {
    return {.scene = "room",
            .client = "anna",
            .role = Role::operator_,
            .seen = seen,
            .ticket = ticket,
            .follows_redirects = true};
  }
  Answer ask(const FleetMember::Join& join, Nanoseconds now = 0s,
             std::chrono::sys_seconds date = kDate) {
    return member.answer(join, now, date).value();
  }
};

/// Two hosts; the first owns the room, and the second is its standby.
class TwoHosts : public ::testing::Test {
 protected:
  TwoHosts() {
    a.member.listed();
    round(0s);  // the owner claims
    b.member.listed();
    round(1s);  // it hears of the other host, and names it
  }
  void round(Nanoseconds now) {
    for (Host* const host : {&a, &b}) host->beat(directory, now);
    for (Host* const host : {&a, &b}) host->read(now);
    for (Host* const host : {&a, &b}) host->write(directory, now);
    for (Host* const host : {&a, &b}) host->read(now);
  }
  MemoryDirectory directory;
  Host a{directory, "a", 11, 1000}, b{directory, "b", 22, 2000};
};

std::string reason(const Answer& answer) { return std::get<Refused>(answer).reason; }
RefusalCode code(const Answer& answer) { return std::get<Refused>(answer).code; }

TEST_F(TwoHosts, TheOwnerTakesAJoinAndTheOtherRedirectsIt) {
  const auto seat = std::get<Seat>(a.ask(a.join()));
  EXPECT_EQ(seat.epoch, (Epoch{1, 11}));
  ASSERT_EQ(seat.hosts.size(), 1u);
  EXPECT_EQ(seat.hosts[0].address, "10.0.0.1");
  EXPECT_EQ(seat.hosts[0].port, 2000);
  FleetMember::Join join = b.join();
  join.ipv6 = true;
  const auto redirected = std::get<Redirected>(b.ask(join));
  EXPECT_EQ(redirected.host.address, "fd00::1");
  EXPECT_EQ(redirected.host.port, 1000);
  EXPECT_EQ(redirected.epoch, (Epoch{1, 11}));
  EXPECT_THAT(a.member.served(), ElementsAre("room"));
  EXPECT_EQ(a.member.elsewhere("room"), std::nullopt);
  EXPECT_EQ(b.member.elsewhere("room"), "a at 10.0.0.1:1000");
}

TEST_F(TwoHosts, AClientThatFollowsNoRedirectIsToldTheHost) {
  FleetMember::Join join = b.join();
  join.follows_redirects = false;
  const Answer answer = b.ask(join);
  EXPECT_EQ(code(answer), RefusalCode::not_supported);
  EXPECT_THAT(reason(answer), HasSubstr("host a of the fleet; join at 10.0.0.1:1000"));
}

TEST_F(TwoHosts, ATicketOpensTheSceneOnce) {
  const std::string ticket = std::get<Redirected>(b.ask(b.join())).ticket;
  EXPECT_TRUE(std::holds_alternative<Seat>(a.ask(a.join({}, ticket))));
  const Answer again = a.ask(a.join({}, ticket));
  EXPECT_EQ(code(again), RefusalCode::bad_ticket);
  EXPECT_THAT(reason(again), HasSubstr("used"));
}

TEST_F(TwoHosts, ATicketOfAnotherOpensNothing) {
  const auto fresh = [&] { return std::get<Redirected>(b.ask(b.join())).ticket; };
  std::string ticket = fresh();
  EXPECT_THAT(reason(a.ask(a.join({}, ticket), 0s, kDate + 40s)), HasSubstr("expired"));
  FleetMember::Join other = a.join();
  other.client = "berta";
  ticket = fresh();
  other.ticket = ticket;
  // The clock went forth and back. That harms no later ticket.
  EXPECT_THAT(reason(a.ask(other, 0s, kDate)), HasSubstr("wrong client"));
  Host c(directory, "c", 33, 3000);
  c.beat(directory, 1s);
  round(2s);
  c.read(2s);
  EXPECT_THAT(reason(c.ask(c.join({}, ticket))), HasSubstr("wrong host"));
  EXPECT_THAT(reason(a.ask(a.join({}, "v4.public.nothing"))), HasSubstr("malformed"));
}

TEST_F(TwoHosts, ATicketIsForOneClientInOneRole) {
  const std::string first = std::get<Redirected>(b.ask(b.join())).ticket;
  FleetMember::Join other = a.join({}, first);
  other.client = "berta";
  EXPECT_THAT(reason(a.ask(other)), HasSubstr("wrong client"));
  const std::string second = std::get<Redirected>(b.ask(b.join())).ticket;
  other = a.join({}, second);
  other.role = Role::observer;
  EXPECT_THAT(reason(a.ask(other)), HasSubstr("wrong role"));
}

TEST_F(TwoHosts, AClientThatHasSeenMoreIsNotTakenAndChangesNothing) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(code(a.ask(a.join({2, 5}))), RefusalCode::failed);
    EXPECT_EQ(code(b.ask(b.join({2, 5}))), RefusalCode::failed);
  }
  EXPECT_TRUE(std::holds_alternative<Seat>(a.ask(a.join({1, 11}))));
}

TEST_F(TwoHosts, TheStandbyTakesOverAfterTheProbeAlone) {
  EXPECT_EQ(b.member.suspect(2s), std::nullopt);  // nobody asks, and heartbeats come
  b.ask(b.join(), 2s);                            // a client says nothing answers there
  const auto suspect = b.member.suspect(2s);
  ASSERT_TRUE(suspect.has_value());
  EXPECT_EQ(suspect->host, (HostName{"a", 11}));
  EXPECT_EQ(suspect->port, 1000);
  EXPECT_THAT(b.member.probed(suspect->host, true), IsEmpty());
  EXPECT_TRUE(std::holds_alternative<Redirected>(b.ask(b.join(), 2s)));
  EXPECT_EQ(b.member.suspect(2s + 100ms), std::nullopt);  // not again so soon
  ASSERT_TRUE(b.member.suspect(3s).has_value());
  EXPECT_THAT(b.member.probed(suspect->host, false), ElementsAre("room"));
  EXPECT_EQ(std::get<Seat>(b.ask(b.join({1, 11}), 3s)).epoch, (Epoch{2, 22}));
  // The former owner lives on: it learns of the new one, and ends its sessions.
  b.write(directory, 3s);
  EXPECT_TRUE(std::holds_alternative<Seat>(a.ask(a.join())));
  a.read(3s);
  EXPECT_THAT(a.member.take_lost(), ElementsAre("room"));
  EXPECT_THAT(a.member.take_lost(), IsEmpty());
  EXPECT_EQ(std::get<Redirected>(a.ask(a.join())).host.port, 2000);
}

TEST_F(TwoHosts, AHostWithoutHeartbeatsIsAskedIfTheDirectoryAnswers) {
  b.beat(directory, 9s);
  b.read(9s);
  ASSERT_TRUE(b.member.suspect(9s).has_value());  // the last beat of the owner came at 1 s
  Host c(directory, "c", 33, 3000);
  c.read(0s);
  EXPECT_EQ(c.member.suspect(100s), std::nullopt);  // the directory says nothing of its own beats
}

/// The owner has died. The third host hears nothing of the standby, which may serve already.
TEST_F(TwoHosts, AThirdHostClaimsNothingBeforeTheStandbyWasAsked) {
  Host c(directory, "c", 33, 3000);
  c.beat(directory, 2s);
  c.read(2s);
  c.member.listed();
  c.beat(directory, 9s);  // the last beats of the others came at 1 s
  const auto owner = c.member.suspect(9s);
  ASSERT_TRUE(owner.has_value());
  EXPECT_EQ(owner->host, (HostName{"a", 11}));
  c.member.probed(owner->host, false);
  c.write(directory, 9s);
  EXPECT_THAT(c.member.served(), IsEmpty());
  const auto standby = c.member.suspect(9s);
  ASSERT_TRUE(standby.has_value());
  EXPECT_EQ(standby->host, (HostName{"b", 22}));
  EXPECT_EQ(standby->port, 2000);
  c.member.probed(standby->host, true);
  c.write(directory, 9s);
  EXPECT_THAT(c.member.served(), IsEmpty());
  c.member.probed(standby->host, false);
  c.write(directory, 9s);
  EXPECT_THAT(c.member.served(), ElementsAre("room"));
}

TEST_F(TwoHosts, AProcessThatBeganAnewIsNotTheOwner) {
  Host again(directory, "a", 12, 1001);
  again.beat(directory, 2s);
  again.read(2s);
  again.member.listed();
  again.write(directory, 2s);  // the standby comes first
  EXPECT_THAT(again.member.served(), IsEmpty());
  b.read(2s);
  EXPECT_EQ(b.member.suspect(2s), std::nullopt);  // it is gone for certain
  b.write(directory, 2s);
  again.read(3s);
  EXPECT_THAT(b.member.served(), ElementsAre("room"));
  EXPECT_EQ(std::get<Redirected>(again.ask(again.join({1, 11}))).host.port, 2000);
}

/// A heartbeat of the process before, delivered late, does not end the process of today for good.
TEST_F(TwoHosts, ALaterHeartbeatShowsThatAProcessLives) {
  EXPECT_THAT(b.member.probed({"a", 11}, false), ElementsAre("room"));
  HostRecord before = Host::about("a", 10, 1000);
  before.beat = 500;
  directory.put(Bucket::hosts, "a", encode(before));
  b.read(2s);
  round(3s);
  Host c(directory, "c", 33, 3000);
  c.beat(directory, 3s);
  round(4s);
  const auto seat = std::get<Seat>(b.ask(b.join()));
  ASSERT_EQ(seat.hosts.size(), 2u);
  EXPECT_EQ(seat.hosts[0].port, 1000);  // the former owner is the standby now
}

/// Two hosts, the first of which is asked for something.
class Wishes : public TwoHosts {
 protected:
  static Wish move(std::uint64_t serial, const HostName& target = {"b", 22}) {
    return {{"a", 11}, serial, WishKind::move, "room", 1, target};
  }
  static Wish drain(std::uint64_t serial, bool on = true) {
    return {{"a", 11}, serial, on ? WishKind::drain : WishKind::undrain, {}, 0, {}};
  }
  void tell(const Wish& wish, Nanoseconds now = 2s) {
    directory.put(Bucket::wishes, wish.host.name, encode(wish));
    a.read(now);
  }
  HostRecord heartbeat_of_a() { return a.member.heartbeat({.hands = 1, .free_shares = {50}}); }
  /// The one handover that A wants now.
  FleetMember::HandOver handover(Nanoseconds now = 2s) {
    const auto all = a.member.hand_overs(now, 7);
    EXPECT_EQ(all.size(), 1u);
    return all.empty() ? FleetMember::HandOver{} : all.front();
  }
  bool wants_none(Nanoseconds now = 2s) { return a.member.hand_overs(now, 7).empty(); }
};

TEST_F(Wishes, AHostThatDrainsHandsItsScenesOver) {
  EXPECT_TRUE(wants_none());
  tell(drain(1));
  EXPECT_TRUE(a.member.take_news());
  EXPECT_FALSE(a.member.take_news());
  EXPECT_FALSE(a.member.drained());
  const FleetMember::HandOver asked = handover();
  EXPECT_EQ(asked.target.port, 2000);
  ASSERT_TRUE(a.member.hand_over(asked, true, 2s));
  EXPECT_EQ(code(a.ask(a.join())), RefusalCode::failed) << "no join here any more";
  EXPECT_THAT(b.member.take_handed(), IsEmpty()) << "before it can know";
  a.write(directory, 2s);
  b.read(2s);
  EXPECT_EQ(code(b.ask(b.join())), RefusalCode::failed) << "nor a redirect back";
  EXPECT_THAT(b.member.take_handed(), ElementsAre("room"));
  EXPECT_EQ(std::get<Seat>(b.ask(b.join({1, 11}))).epoch, (Epoch{2, 22}));
  EXPECT_THAT(a.member.take_lost(), IsEmpty()) << "the sessions go on until the next owner is seen";
  EXPECT_FALSE(a.member.drained());
  b.write(directory, 2s);
  a.read(2s);
  EXPECT_THAT(a.member.take_lost(), ElementsAre("room"));
  EXPECT_TRUE(a.member.drained());
  EXPECT_EQ(std::get<Redirected>(a.ask(a.join({1, 11}))).host.port, 2000);
  // It is no standby, and takes nothing back.
  round(3s);
  round(4s);
  EXPECT_THAT(a.member.served(), IsEmpty());
  EXPECT_EQ(decode_scene_record(directory.list(Bucket::scenes)->front().value)->standby.number, 0u);
  // A directory that delivers the wish once more, after the opposite one, changes nothing.
  tell(drain(2, false), 5s);
  tell(drain(1), 5s);
  EXPECT_FALSE(heartbeat_of_a().draining);
  round(6s);
  round(7s);
  EXPECT_EQ(decode_scene_record(directory.list(Bucket::scenes)->front().value)->standby.number,
            11u);
}

TEST_F(Wishes, AHostThatDrainsSaysWhatItKeeps) {
  b.member.drain(false);
  round(2s);
  tell(drain(1));
  EXPECT_TRUE(wants_none());
  EXPECT_THAT(heartbeat_of_a().kept, HasSubstr("room: no other host that takes scenes has its"));
  EXPECT_TRUE(a.member.drained()) << "as far as it can";
  EXPECT_THAT(a.member.served(), ElementsAre("room"));
  tell(drain(2, false));
  EXPECT_EQ(heartbeat_of_a().kept, "");
}

TEST_F(Wishes, AWishIsForOneProcessAndOneTerm) {
  Wish wish = move(1);
  wish.host.number = 12;  // another process of that name
  tell(wish);
  EXPECT_TRUE(wants_none());
  EXPECT_EQ(heartbeat_of_a().wish, 0u);
  wish = move(2);
  wish.term = 7;
  tell(wish);
  EXPECT_TRUE(wants_none());
  EXPECT_EQ(heartbeat_of_a().wish, 2u);
  EXPECT_THAT(heartbeat_of_a().wish_refusal, HasSubstr("does not serve scene room in term 7"));
  tell(move(3));
  EXPECT_EQ(heartbeat_of_a().wish_refusal, "");
  EXPECT_EQ(handover().target.host, (HostName{"b", 22}));
  EXPECT_TRUE(a.member.hand_over(handover(), true, 2s));
}

TEST_F(Wishes, AHostThatCannotTakeTheSceneIsRefused) {
  tell(move(1, {"c", 33}));
  EXPECT_THAT(heartbeat_of_a().wish_refusal, HasSubstr("host c gives no sign of life"));
  SceneDigest other{};
  other[0] = 1;
  FleetMember stranger(Host::about("d", 44, 4000), {{"room", other}},
                       SigningKeys(paseto::SigningKey::random()));
  const HostRecord record = stranger.heartbeat({.hands = 0, .free_shares = {100}});
  directory.put(Bucket::hosts, "d", encode(record));
  a.read(2s);
  tell(move(2, {"d", 44}));
  EXPECT_THAT(heartbeat_of_a().wish_refusal,
              HasSubstr("host d has no scene of that name with the"));
  b.member.drain(false);
  round(2s);
  tell(move(3));
  EXPECT_THAT(heartbeat_of_a().wish_refusal, HasSubstr("host b drains"));
  EXPECT_TRUE(wants_none());
}

TEST_F(Wishes, ATargetWithoutAnAnswerChangesNothing) {
  tell(move(1));
  EXPECT_FALSE(a.member.hand_over(handover(), false, 2s));
  EXPECT_TRUE(std::holds_alternative<Seat>(a.ask(a.join())));
  EXPECT_THAT(heartbeat_of_a().wish_refusal, HasSubstr("host b gives no answer"));
  EXPECT_TRUE(wants_none());
}

/// The target has died after it was asked.
TEST_F(Wishes, ASceneThatNobodyTakesComesBack) {
  tell(drain(1));
  ASSERT_TRUE(a.member.hand_over(handover(), true, 2s));
  a.write(directory, 2s);
  EXPECT_THAT(a.member.served(), IsEmpty());
  a.beat(directory, 2s + kTakeTime);
  a.write(directory, 2s + kTakeTime);
  EXPECT_THAT(a.member.served(), ElementsAre("room"));
  EXPECT_THAT(a.member.take_lost(), IsEmpty()) << "its sessions have gone on";
  EXPECT_EQ(std::get<Seat>(a.ask(a.join())).epoch, (Epoch{3, 11}));
  EXPECT_THAT(heartbeat_of_a().kept, HasSubstr("room: host b has not taken it"));
  EXPECT_TRUE(wants_none(3s + kTakeTime)) << "not at once again";
  // Too late: the other host sees the later epoch first, or ends when it sees it.
  b.read(5s);
  EXPECT_THAT(b.member.take_handed(), IsEmpty());
}

/// Nothing is handed over through a directory that does not answer.
TEST_F(Wishes, WithoutTheDirectoryAHostKeepsItsScenes) {
  a.member.drain(true);
  EXPECT_TRUE(wants_none(2s + kSilent));
  EXPECT_THAT(heartbeat_of_a().kept, HasSubstr("the directory does not answer"));
  EXPECT_TRUE(a.member.drained());
  tell(drain(1, false));
  EXPECT_TRUE(heartbeat_of_a().draining);
  EXPECT_THAT(heartbeat_of_a().wish_refusal, HasSubstr("about to end"));
}

TEST(FleetMember, NothingIsClaimedBeforeTheDirectoryWasRead) {
  MemoryDirectory directory;
  Host a(directory, "a", 11, 1000);
  a.write(directory, 0s);
  EXPECT_EQ(code(a.ask(a.join())), RefusalCode::failed);
  a.member.listed();
  a.write(directory, 0s);
  EXPECT_TRUE(std::holds_alternative<Seat>(a.ask(a.join())));
  FleetMember::Join other = a.join();
  other.scene = "other";
  EXPECT_EQ(a.member.answer(other, 0s, kDate), std::nullopt);
}

/// The answer to the claim is lost, and the directory has the record.
TEST(FleetMember, AClaimWithoutAnAnswerIsMadeAgain) {
  MemoryDirectory directory;
  Host a(directory, "a", 11, 1000);
  a.member.listed();
  const auto writes = a.member.writes(0s, 1);
  ASSERT_EQ(writes.size(), 1u);
  directory.compare_and_swap(Bucket::scenes, "room", encode(writes[0].record), 0);
  a.member.finish(writes[0], {WriteResult::unknown, 0});
  a.read(0s);
  EXPECT_EQ(code(a.ask(a.join())), RefusalCode::failed);  // never redirected to itself
  a.write(directory, 1s);
  EXPECT_EQ(std::get<Seat>(a.ask(a.join())).epoch, (Epoch{2, 11}));
}

TEST_F(TwoHosts, OnlyAHostWithTheSameFilesIsAStandby) {
  SceneDigest other{};
  other[0] = 1;
  FleetMember stranger(Host::about("d", 44, 4000), {{"room", other}},
                       SigningKeys(paseto::SigningKey::random()));
  MemoryDirectory fresh;
  Host owner(fresh, "o", 55, 5000);
  owner.member.listed();
  const HostRecord record = stranger.heartbeat({.hands = 0, .free_shares = {100}});
  fresh.put(Bucket::hosts, "d", encode(record));
  for (const auto now : {0s, 1s, 2s}) {
    owner.beat(fresh, now);
    owner.read(now);
    owner.write(fresh, now);
  }
  const auto entries = fresh.list(Bucket::scenes);
  ASSERT_TRUE(entries && entries->size() == 1);
  EXPECT_EQ(decode_scene_record(entries->front().value)->standby.number, 0u);
}

}  // namespace
}  // namespace feltwire::fleet_member_test
