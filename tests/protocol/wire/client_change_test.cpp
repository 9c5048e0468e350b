// Tests a change that an admin requests from a client. The change must fit in every reply and
// arrive unchanged. Invalid bytes must be refused, and each client decides which bounding method it
// accepts.

#include "protocol/session/client_change.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::client_change_test {
namespace {

using ::testing::HasSubstr;
constexpr std::size_t kHeaderAndTag = 40;

/// Returns a change with the longest possible method name.
ClientChange longest() {
  return {.number = 63,
          .law = LawChoice{MethodName(std::string(kLongestMethodName, 'm')), Projection::joint,
                           Storage::elastic},
          .link = LinkQuality{.delay = 0.25, .jitter = 0.125, .loss = 0.5}};
}

/// Returns a reply to a hand with all possible contents.
Reply fullest() {
  Reply reply;
  reply.sample_index = 7;
  reply.rotation = reply.predicted = reply.modelled = true;
  reply.withheld = 1;
  reply.rates = {Vec3::Ones(), Vec3::Ones(), Vec3::Ones()};
  for (const Vec3& unit : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())})
    reply.normals.add(unit);
  reply.model.count = kMaxPatches;
  reply.model.reach = 0.01;
  reply.model.scene = 3;
  for (SurfacePatch& patch : reply.model.patches) {
    patch.normal = patch.axis = Vec3::UnitZ();
    patch.material.stiffness = 500.0;
    patch.offset = 0.01;
  }
  reply.remote = Remote{};
  return reply;
}

TEST(ClientChange, ArrivesInTheFullestReplyThatThereIs) {
  Encoder encoder;
  Reply sent = fullest();
  const std::size_t without = encoder.reply(sent).size();
  sent.change = longest();
  const Bytes payload = encoder.reply(sent);
  EXPECT_LE(payload.size() + kHeaderAndTag, kMaxDatagram);
  EXPECT_LE(payload.size(), without + 136);  // the limit of PROTOCOL.md
  Reply received;
  ASSERT_EQ(decode(payload, received), DropReason::none);
  EXPECT_EQ(received.change, sent.change);

  sent.change = ClientChange{.number = 1, .law = LawChoice{MethodName("shaped")}, .link = {}};
  ASSERT_EQ(decode(encoder.reply(sent), received), DropReason::none);
  EXPECT_EQ(received.change, sent.change);
  sent.change = ClientChange{.number = 2, .law = {}, .link = LinkQuality{}};
  ASSERT_EQ(decode(encoder.reply(sent), received), DropReason::none);
  EXPECT_EQ(received.change, sent.change);
  sent.change.reset();
  ASSERT_EQ(decode(encoder.reply(sent), received), DropReason::none);
  EXPECT_FALSE(received.change);
}

TEST(ClientChange, TakesNoMemoryOnItsWay) {
  Encoder encoder;
  Reply sent = fullest(), received;
  sent.change = longest();
  encoder.reply(sent);  // The first reply allocates the buffer.
  const std::size_t before = test::allocations();
  const bool arrived = decode(encoder.reply(sent), received) == DropReason::none;
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(arrived);
}

TEST(ClientChange, GarbageDoesNotArrive) {
  Encoder encoder;
  Reply sent = fullest(), received;
  const auto refused = [&](const ClientChange& change) {
    sent.change = change;
    return decode(encoder.reply(sent), received);
  };
  for (const int wild : {0, 64, 255}) {
    const auto number = static_cast<std::uint8_t>(wild);
    EXPECT_EQ(refused({.number = number, .law = {}, .link = {}}), DropReason::count);
  }
  ClientChange change = longest();
  change.law->projection = static_cast<Projection>(2);
  EXPECT_EQ(refused(change), DropReason::count);
  change = longest();
  change.law->storage = static_cast<Storage>(9);
  EXPECT_EQ(refused(change), DropReason::count);
  for (double LinkQuality::*field : {&LinkQuality::delay, &LinkQuality::jitter, &LinkQuality::loss})
    for (const double value : {-1e-9, 10.5, std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()}) {
      change = longest();
      (*change.link).*field = value;
      EXPECT_EQ(refused(change), DropReason::not_finite) << value;
    }
}

TEST(ClientChange, IsAcknowledgedBesideTheRestOfAReport) {
  Encoder encoder;
  SampleBatch sent, received;
  sent.count = 1;
  sent.samples[0].index = 1;
  for (const bool refused : {false, true})
    for (const int n : {0, 1, 42, 63}) {
      const auto number = static_cast<std::uint8_t>(n);
      sent.report = HandReport{.has_account = !refused,
                               .late_ticks = 0xABCDEF,
                               .change = number,
                               .change_refused = refused};
      ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
      EXPECT_EQ(received.report->change, number);
      EXPECT_EQ(received.report->change_refused, refused);
      EXPECT_EQ(received.report->has_account, !refused);
      EXPECT_EQ(received.report->late_ticks, 0xABCDEFu);
    }
}

TEST(ClientChange, NumbersFollowEachOtherRound) {
  EXPECT_EQ(number_after(0), 1);
  EXPECT_EQ(number_after(62), 63);
  EXPECT_EQ(number_after(63), 1);
}

TEST(ClientChange, ControlMessagesCarryIt) {
  const auto again = [](const control::Message& message) {
    const auto frame = control::encode(message);
    return control::decode(Bytes(frame).subspan(control::kFrameLengthSize));
  };
  const auto set = again(control::SetLink{.session = 77, .link = {0.1, 0.2, 0.3}});
  ASSERT_TRUE(set && std::holds_alternative<control::SetLink>(*set));
  EXPECT_EQ(std::get<control::SetLink>(*set).session, 77u);
  EXPECT_EQ(std::get<control::SetLink>(*set).link, (LinkQuality{0.1, 0.2, 0.3}));
  const auto lead = again(control::SetLead{.session = 78, .share = 0.25});
  ASSERT_TRUE(lead && std::holds_alternative<control::SetLead>(*lead));
  EXPECT_EQ(std::get<control::SetLead>(*lead).session, 78u);
  EXPECT_EQ(std::get<control::SetLead>(*lead).share, 0.25);
  control::JoinRequest join{.client = "c", .scene = "s", .device = {}, .parameters = {}};
  join.takes = {.laws = LawsTaken::safe, .link = true};
  const auto joined = again(join);
  ASSERT_TRUE(joined);
  EXPECT_EQ(std::get<control::JoinRequest>(*joined).takes, join.takes);
  control::SessionDescriptions list;
  list.sessions.emplace_back();
  list.sessions[0].changes.takes = join.takes;
  list.sessions[0].changes.asked = "link delay 1 ms";
  list.sessions[0].changes.answer = ChangeAnswer::refused;
  const auto listed = again(list);
  ASSERT_TRUE(listed);
  const auto& entry = std::get<control::SessionDescriptions>(*listed).sessions[0];
  EXPECT_EQ(entry.changes.takes, join.takes);
  EXPECT_EQ(entry.changes.asked, "link delay 1 ms");
  EXPECT_EQ(entry.changes.answer, ChangeAnswer::refused);
}

SessionParameters started(std::string_view mode, BoundingSide side = BoundingSide::client) {
  SessionParameters p;
  p.mode = mode;
  p.side = side;
  return p;
}
LawChoice law(std::string_view mode) { return LawChoice{MethodName(mode)}; }

/// A person may hold the client's device. Such a client must accept only its own method, or a
/// method that is passive by itself.
TEST(LawsTaken, SafeOnesRaiseNoRisk) {
  const SessionParameters shaped = started("shaped"), unbounded = started("none");
  using enum LawsTaken;
  for (const char* passive : {"contact_frame", "energy_tank"})
    EXPECT_FALSE(refuses_law(shaped, law(passive), safe)) << passive;
  EXPECT_FALSE(refuses_law(shaped, law("shaped"), safe));  // The client returns to its own method.
  for (const char* not_by_itself : {"none", "midpoint", "credited"}) {
    EXPECT_THAT(refuses_law(shaped, law(not_by_itself), safe).value_or(""),
                HasSubstr("a person's hand may be at this device"))
        << not_by_itself;
    EXPECT_FALSE(refuses_law(shaped, law(not_by_itself), any)) << not_by_itself;
  }
  EXPECT_FALSE(refuses_law(unbounded, law("none"), safe));  // The operator chose this method.
  EXPECT_TRUE(refuses_law(unbounded, law("shaped"), safe));
}

TEST(LawsTaken, NobodyTakesWhatCannotTakeOver) {
  using enum LawsTaken;
  const SessionParameters shaped = started("shaped");
  EXPECT_THAT(*refuses_law(shaped, law("contact_frame"), none), HasSubstr("--changes"));
  EXPECT_THAT(*refuses_law(shaped, law("total_energy"), any),
              HasSubstr("bounds forces from below"));
  EXPECT_THAT(*refuses_law(started("per_axis"), law("contact_frame"), any),
              HasSubstr("the mode per_axis bounds forces from below"));
  EXPECT_THAT(*refuses_law(shaped, law("virtual_coupling"), any), HasSubstr("side"));
  EXPECT_THAT(*refuses_law(shaped, law("no_such_law"), any), HasSubstr("choose one of"));
  for (const BoundingSide side : {BoundingSide::server, BoundingSide::both})
    EXPECT_THAT(*refuses_law(started("contact_frame", side), law("energy_tank"), any),
                HasSubstr("does not run at the client alone"));
}

}  // namespace
}  // namespace feltwire::client_change_test
