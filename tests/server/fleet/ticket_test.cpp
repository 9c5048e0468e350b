// Tests tickets: what each is good for, and that it is good for nothing else.

#include "server/fleet/ticket.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/fleet/signing_keys.hpp"

namespace feltwire::ticket_test {
namespace {

using namespace std::chrono_literals;
using paseto::SigningKey;

const std::chrono::sys_seconds kNow =
    std::chrono::sys_days(std::chrono::year(2026) / 12 / 31) + 23h + 59min + 45s;
constexpr Epoch kEpoch{3, std::numeric_limits<HostNumber>::max()};

Ticket ticket() {
  return {"room", "anna \"a\" \xc3\xa4", Role::operator_, "host-b", kEpoch, kNow, {}};
}

class Tickets : public ::testing::Test {
 protected:
  Tickets() { keys_.set("host-a", signing_.valid()); }

  std::string issued(const std::function<void(Ticket&)>& change = [](Ticket&) {}) {
    Ticket made = ticket();
    change(made);
    return issue_ticket(made, signing_.signing());
  }
  std::optional<TicketRefusal> check(const std::string& text, std::chrono::sys_seconds now = kNow) {
    return gate_.check(text, place_, keys_, now).refusal;
  }

  SigningKeys signing_{SigningKey::random()};
  TicketKeys keys_;
  TicketGate gate_{1000};
  TicketPlace place_{"room", "host-b", kEpoch};
};

TEST_F(Tickets, OneOpensOneJoin) {
  const std::string text = issued();
  EXPECT_TRUE(text.starts_with("v4.public."));
  const auto first = gate_.check(text, place_, keys_, kNow);
  EXPECT_EQ(first.refusal, std::nullopt);
  Ticket read = first.ticket;
  read.nonce = {};
  EXPECT_EQ(read, ticket());
  EXPECT_EQ(check(text), TicketRefusal::used);
  EXPECT_EQ(check(issued()), std::nullopt) << "another of the same client";
}

TEST_F(Tickets, ItIsForOneSceneHostAndEpoch) {
  EXPECT_EQ(check(issued([](Ticket& t) { t.scene = "hall"; })), TicketRefusal::wrong_scene);
  EXPECT_EQ(check(issued([](Ticket& t) { t.host = "host-c"; })), TicketRefusal::wrong_host);
  for (const Epoch wrong : {Epoch{2, kEpoch.holder}, Epoch{4, kEpoch.holder}, Epoch{3, 1}})
    EXPECT_EQ(check(issued([&](Ticket& t) { t.epoch = wrong; })), TicketRefusal::wrong_epoch);
}

TEST_F(Tickets, AWrongPlaceDoesNotUseItUp) {
  const std::string text = issued();
  place_.scene = "hall";
  EXPECT_EQ(check(text), TicketRefusal::wrong_scene);
  place_.scene = "room";
  EXPECT_EQ(check(text), std::nullopt);
}

TEST_F(Tickets, ItLivesHalfAMinute) {
  const auto at = [&](std::chrono::seconds after) {
    TicketGate fresh(10);
    return fresh.check(issued(), place_, keys_, kNow + after).refusal;
  };
  EXPECT_EQ(at(0s), std::nullopt);
  EXPECT_EQ(at(34s), std::nullopt) << "the clocks of two hosts differ by up to 5 s";
  EXPECT_EQ(at(35s), TicketRefusal::expired);
  EXPECT_EQ(at(-5s), std::nullopt);
  EXPECT_EQ(at(-6s), TicketRefusal::early);
}

TEST_F(Tickets, AClockThatIsSetBackRevivesNone) {
  const std::string used = issued(), unused = issued();
  EXPECT_EQ(check(used), std::nullopt);
  EXPECT_EQ(check(unused, kNow + 40s), TicketRefusal::expired);
  EXPECT_EQ(check(unused, kNow), TicketRefusal::expired);
  EXPECT_EQ(check(used, kNow), TicketRefusal::expired);
}

/// A wrong clock for a moment, as after a machine was resumed, must not end the tickets of a host.
TEST_F(Tickets, AClockThatJumpsAndComesBackTakesNewOnes) {
  const std::string used = issued(), unused = issued();
  EXPECT_EQ(check(used), std::nullopt);
  EXPECT_EQ(check(unused, kNow + 24h), TicketRefusal::expired);
  const auto later = [](Ticket& t) { t.issued = kNow + 2s; };
  const std::string fresh = issued(later);
  EXPECT_EQ(check(fresh, kNow + 3s), std::nullopt);
  EXPECT_EQ(check(fresh, kNow + 3s), TicketRefusal::used);
  EXPECT_EQ(check(used, kNow + 3s), TicketRefusal::expired) << "its use is forgotten by now";
  EXPECT_EQ(check(issued(later), kNow - 10s), TicketRefusal::expired) << "set back again";
}

TEST_F(Tickets, ASmallStepBackRefusesNone) {
  EXPECT_EQ(check(issued(), kNow + 5s), std::nullopt);
  EXPECT_EQ(check(issued(), kNow), std::nullopt);
}

TEST_F(Tickets, ANameThatNoHostWouldReadIsNotSigned) {
  for (const std::string& wrong : {std::string(), std::string(129, 'a'), std::string("\xff")}) {
    EXPECT_THROW(issued([&](Ticket& t) { t.scene = wrong; }), std::invalid_argument);
    EXPECT_THROW(issued([&](Ticket& t) { t.client = wrong; }), std::invalid_argument);
    EXPECT_THROW(issued([&](Ticket& t) { t.host = wrong; }), std::invalid_argument);
  }
  EXPECT_EQ(check(issued([](Ticket& t) { t.client = std::string(128, 'a'); })), std::nullopt);
}

/// A host that copies another's public key from the directory must not end the other's tickets.
TEST_F(Tickets, AKeyThatTwoHostsAnnounceStays) {
  keys_.set("host-c", signing_.valid());
  EXPECT_EQ(keys_.size(), 1u);
  keys_.forget("host-c");
  EXPECT_EQ(check(issued()), std::nullopt);
  keys_.forget("host-a");
  EXPECT_EQ(check(issued()), TicketRefusal::unknown_key);
}

TEST_F(Tickets, NoOtherTextIsOne) {
  const std::string text = issued();
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_NE(check(changed), std::nullopt) << i;
  }
  EXPECT_EQ(check(""), TicketRefusal::malformed);
  EXPECT_EQ(check("fw_0123456789ab_x"), TicketRefusal::malformed);
  EXPECT_EQ(check(text), std::nullopt) << "and none of these used it up";
}

TEST_F(Tickets, OnlyAHostOfTheFleetSignsOne) {
  EXPECT_EQ(check(issue_ticket(ticket(), SigningKey::random())), TicketRefusal::unknown_key);
  const std::string footer = *paseto::unverified_footer(issued());
  EXPECT_EQ(check(paseto::sign("{}", SigningKey::random(), footer, "feltwire ticket 1")),
            TicketRefusal::forged);
  EXPECT_EQ(check(paseto::sign("{}", signing_.signing(), footer)), TicketRefusal::forged)
      << "signed for another purpose";
  EXPECT_EQ(check(paseto::sign("{}", signing_.signing(), footer, "feltwire ticket 1")),
            TicketRefusal::malformed);
}

TEST_F(Tickets, TwoKeysOfAHostAreValid) {
  const SigningKey second = SigningKey::random(), third = SigningKey::random();
  const std::string by_first = issued();
  signing_.change();
  EXPECT_EQ(signing_.valid().size(), 1u) << "nothing is announced";
  signing_.announce(second);
  EXPECT_EQ(signing_.signing().public_key(), signing_.valid().front());
  EXPECT_NE(signing_.signing().public_key(), second.public_key()) << "announced, not yet used";
  keys_.set("host-a", signing_.valid());
  signing_.change();
  EXPECT_EQ(signing_.signing().public_key(), second.public_key());
  keys_.set("host-a", signing_.valid());
  EXPECT_EQ(check(by_first), std::nullopt) << "the former key stays valid";
  EXPECT_EQ(check(issued()), std::nullopt);
  const std::string by_second = issued();
  signing_.announce(third);
  signing_.change();
  keys_.set("host-a", signing_.valid());
  EXPECT_EQ(check(issued()), std::nullopt);
  EXPECT_EQ(check(by_second), std::nullopt);
  EXPECT_EQ(keys_.size(), 2u);
  signing_.announce(SigningKey::random());
  keys_.set("host-a", signing_.valid());
  EXPECT_EQ(check(issue_ticket(ticket(), second)), TicketRefusal::unknown_key);
  EXPECT_EQ(check(issued()), std::nullopt);
  keys_.forget("host-a");
  EXPECT_EQ(check(issued()), TicketRefusal::unknown_key);
}

TEST_F(Tickets, AHostHasNoMoreThanTwoKeys) {
  std::vector<paseto::PublicKey> different;
  for (int i = 0; i < 5; ++i) different.push_back(SigningKey::random().public_key());
  keys_.set("host-c", different);
  EXPECT_EQ(keys_.size(), 3u);
}

TEST(ReplayCache, KeepsEachForItsPeriodInBoundedMemory) {
  ReplayCache cache(30s, 2);
  const auto nonce = [](std::uint8_t number) { return ReplayCache::Nonce{number}; };
  using Use = ReplayCache::Use;
  EXPECT_EQ(cache.use(nonce(1), 100s), Use::first);
  EXPECT_EQ(cache.use(nonce(2), 120s), Use::first);
  EXPECT_EQ(cache.use(nonce(3), 121s), Use::full);
  EXPECT_EQ(cache.use(nonce(1), 122s), Use::again) << "also when it is full";
  EXPECT_EQ(cache.use(nonce(3), 131s), Use::first) << "a new set";
  EXPECT_EQ(cache.use(nonce(2), 149s), Use::again) << "its 30 s are not over";
  EXPECT_EQ(cache.use(nonce(4), 150s), Use::first);
  EXPECT_EQ(cache.size(), 4u) << "twice the capacity, and no more";
  EXPECT_EQ(cache.use(nonce(5), 160s), Use::full);
  EXPECT_EQ(cache.use(nonce(1), 165s), Use::first) << "forgotten";
  EXPECT_EQ(cache.use(nonce(9), 999s), Use::first);
  EXPECT_EQ(cache.size(), 1u);
}

}  // namespace
}  // namespace feltwire::ticket_test
