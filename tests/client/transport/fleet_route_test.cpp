// A client in a fleet: it follows redirects, refuses former owners, and finds the hosts that are
// left.

#include "client/transport/fleet_route.hpp"

#include <gmock/gmock.h>

#include <set>

#include "client/transport/backoff.hpp"
#include "client/transport/redirect_scope.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::fleet_route_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::ControlPeer;
using testing::error_of;
using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kPatience{10'000};

control::JoinRequest request() { return {"tester", "wall", builtin_device("simulated"), {}}; }

control::FleetHost host_at(std::uint16_t port) {
  return {"127.0.0.1", port, fingerprint(test::identity())};
}
std::vector<std::uint8_t> accepted_at(const Epoch& epoch,
                                      std::vector<control::FleetHost> hosts = {}) {
  control::JoinAccepted accepted;
  accepted.session = 77;
  accepted.port_offset = 1;
  accepted.silence_timeout = 2.0;
  accepted.epoch = epoch;
  accepted.hosts = std::move(hosts);
  return control::encode(testing::with_secrets(accepted));
}
std::vector<std::uint8_t> redirect_to(const control::FleetHost& host, const Epoch& epoch) {
  return control::encode(control::Redirected{host, "a ticket", epoch});
}
control::JoinRequest asked(ControlPeer& peer) {
  return std::get<control::JoinRequest>(peer.request().value());
}

TEST(FleetRoute, ARedirectIsFollowedWithItsTicket) {
  const Epoch epoch{7, 2};
  ControlPeer owner(accepted_at(epoch));
  ControlPeer first(redirect_to(host_at(owner.port()), epoch));
  FleetRoute route(first.access());
  const Joined joined = route.join(request(), kPatience);
  EXPECT_EQ(joined.host.endpoint, (Endpoint{"127.0.0.1", owner.port()}));
  EXPECT_EQ(joined.accepted.epoch, epoch);
  EXPECT_EQ(route.host().endpoint, joined.host.endpoint);
  EXPECT_EQ(route.highest(), epoch);
  const control::JoinRequest at_first = asked(first), at_owner = asked(owner);
  EXPECT_TRUE(at_first.follows_redirects);
  EXPECT_EQ(at_first.ticket, "");
  EXPECT_EQ(at_first.epoch, Epoch{});
  EXPECT_EQ(at_owner.ticket, "a ticket");
  EXPECT_EQ(at_owner.epoch, epoch);
}

TEST(FleetRoute, ThreeRedirectsAreFollowedAndNoFourth) {
  const Epoch epoch{7, 2};
  ControlPeer last(accepted_at(epoch));
  ControlPeer third(redirect_to(host_at(last.port()), epoch));
  ControlPeer second(redirect_to(host_at(third.port()), epoch));
  ControlPeer first(redirect_to(host_at(second.port()), epoch));
  EXPECT_EQ(join(first.access(), request(), kPatience).host.endpoint.port, last.port());

  ControlPeer fifth(accepted_at(epoch));
  ControlPeer d(redirect_to(host_at(fifth.port()), epoch));
  ControlPeer c(redirect_to(host_at(d.port()), epoch));
  ControlPeer b(redirect_to(host_at(c.port()), epoch));
  ControlPeer a(redirect_to(host_at(b.port()), epoch));
  EXPECT_THAT(error_of<SessionError>([&] { join(a.access(), request(), kPatience); }),
              HasSubstr("on and on"));
}

TEST(FleetRoute, AnEarlierOwnerGetsNoSession) {
  control::JoinRequest wanted = request();
  wanted.epoch = {8, 1};
  ControlPeer former(accepted_at({7, 9}));
  const std::string said =
      error_of<SessionError>([&] { ask_to_join(former.access(), wanted, kPatience, {}); });
  EXPECT_THAT(said, HasSubstr("has served the scene before another host did"));
  ControlPeer without_fleet(accepted_at({}));
  EXPECT_THAT(
      error_of<SessionError>([&] { ask_to_join(without_fleet.access(), wanted, kPatience, {}); }),
      HasSubstr("has served the scene before another host did"));
  ControlPeer behind(redirect_to(host_at(1), {7, 9}));
  EXPECT_THAT(error_of<SessionError>([&] { ask_to_join(behind.access(), wanted, kPatience, {}); }),
              HasSubstr("knows an earlier owner"));
  ControlPeer owner(accepted_at({8, 1}));
  EXPECT_NO_THROW(ask_to_join(owner.access(), wanted, kPatience, {}));
}

TEST(FleetRoute, ARedirectRaisesTheEpochEvenIfTheHostIsAway) {
  std::uint16_t closed = 0;
  {
    const testing::LocalSocket socket(SOCK_STREAM);
    closed = socket.port();
  }
  ControlPeer first(redirect_to(host_at(closed), {9, 4}));
  FleetRoute route(first.access());
  EXPECT_THROW(route.join(request(), kPatience), SessionError);
  EXPECT_EQ(route.highest(), (Epoch{9, 4}));
}

TEST(FleetRoute, TheNamedFingerprintIsTheOnlyOne) {
  const Epoch epoch{7, 2};
  control::FleetHost stranger;
  ControlPeer owner(accepted_at(epoch));
  stranger = host_at(owner.port());
  stranger.fingerprint[0] ^= 1U;
  ControlPeer first(redirect_to(stranger, epoch));
  ServerAccess access = first.access();
  // The authority would vouch for the owner's certificate.
  access.credentials.trust = Authorities{test::identity().certificate};
  EXPECT_THAT(error_of<LastingError>([&] { join(access, request(), kPatience); }),
              HasSubstr("is not the server whose fingerprint was given"));
}

TEST(FleetRoute, AServerThatMayNotNameAHostIsNotFollowed) {
  ControlPeer first(redirect_to({"0.0.0.0", 1, {}}, {7, 2}));
  EXPECT_THAT(error_of<LastingError>([&] { join(first.access(), request(), kPatience); }),
              AllOf(HasSubstr("sends this client to 0.0.0.0"), HasSubstr("to be trusted")));
}

TEST(FleetRoute, AnotherHostIsAskedWhereTheFirstIsSilent) {
  ControlPeer standby(accepted_at({8, 5}));
  ControlPeer owner(accepted_at({7, 2}, {host_at(standby.port()), {"0.0.0.0", 1, {}}}));
  FleetRoute route(owner.access());
  const Joined joined = route.join(request(), kPatience);
  ASSERT_EQ(joined.others.size(), 1u);  // the second host may not be named
  asked(owner);                         // the owner has closed its port
  EXPECT_EQ(route.join(request(), kPatience).host.endpoint.port, standby.port());
  EXPECT_EQ(route.highest(), (Epoch{8, 5}));
}

TEST(FleetRoute, OnlyIfEveryHostRefusesForGoodIsItFinal) {
  const auto refusal =
      control::encode(control::Refused{control::RefusalCode::unauthenticated, "no good token"});
  ControlPeer standby(refusal);
  ControlPeer owner(accepted_at({7, 2}, {host_at(standby.port())}));
  FleetRoute route(owner.access());
  route.join(request(), kPatience);
  asked(owner);
  const std::string said = error_of<SessionError>([&] { route.join(request(), kPatience); });
  EXPECT_THAT(said, HasSubstr("cannot connect"));  // the owner may come back
  EXPECT_EQ(asked(standby).epoch, (Epoch{7, 2}));
}

TEST(RedirectScope, AHostIsInANetworkAsWideAsTheServers) {
  const auto forbids = [](const char* by, const char* named) {
    return forbidden_host(asio::ip::make_address(by), {named, 1, {}}).has_value();
  };
  for (const char* anywhere : {"8.8.8.8", "2001:4860::1"}) {
    for (const char* by : {"127.0.0.1", "::1", "10.0.0.1", "fd00::1", "9.9.9.9", "2600::1"})
      EXPECT_FALSE(forbids(by, anywhere)) << by;
  }
  for (const char* narrow : {"10.1.2.3", "172.16.0.1", "172.31.255.255", "192.168.1.1",
                             "100.64.0.1", "fd00::1", "::ffff:10.0.0.1"}) {
    EXPECT_TRUE(forbids("9.9.9.9", narrow)) << narrow;
    EXPECT_TRUE(forbids("2600::1", narrow)) << narrow;
    EXPECT_FALSE(forbids("192.168.7.7", narrow)) << narrow;
    EXPECT_FALSE(forbids("::1", narrow)) << narrow;
  }
  for (const char* own : {"127.0.0.1", "127.9.9.9", "::1", "::ffff:127.0.0.1"}) {
    EXPECT_TRUE(forbids("9.9.9.9", own)) << own;
    EXPECT_TRUE(forbids("10.0.0.1", own)) << own;
    EXPECT_FALSE(forbids("127.0.0.1", own)) << own;
  }
  for (const char* never : {"0.0.0.0", "::", "224.0.0.1", "ff02::1", "255.255.255.255",
                            "169.254.1.1", "fe80::1", "fe80::1%lo", "localhost", "", "10.0.0.1:5"})
    EXPECT_TRUE(forbids("127.0.0.1", never)) << never;
  for (const char* near : {"172.32.0.1", "172.15.0.1", "100.128.0.1", "192.169.0.1", "11.0.0.1"})
    EXPECT_FALSE(forbids("9.9.9.9", near)) << near;
  EXPECT_TRUE(forbidden_host(asio::ip::make_address("127.0.0.1"), {"127.0.0.1", 0, {}}));
}

TEST(Backoff, WaitsAreDrawnBelowALimitThatDoubles) {
  constexpr int kWaits = 6, kClients = 400;
  constexpr std::array<int, kWaits> kLimits = {250, 500, 1000, 2000, 4000, 4000};
  std::array<double, kWaits> sums{};
  std::set<std::int64_t> firsts;
  for (std::uint64_t seed = 1; seed <= kClients; ++seed) {
    Backoff backoff(250ms, 4000ms, seed);
    for (std::size_t i = 0; i < kWaits; ++i) {
      const auto wait = backoff.next().count();
      ASSERT_GE(wait, 0);
      ASSERT_LE(wait, kLimits[i]);
      sums[i] += static_cast<double>(wait);
      if (i == 0) firsts.insert(wait);
    }
    backoff.reset();
    ASSERT_LE(backoff.next(), 250ms);
  }
  for (std::size_t i = 0; i < kWaits; ++i)
    EXPECT_NEAR(sums[i] / kClients, kLimits[i] / 2.0, kLimits[i] / 12.0) << i;
  EXPECT_GT(firsts.size(), 150u);  // no herd comes back in one moment
}

}  // namespace
}  // namespace feltwire::fleet_route_test
