// Some refusals end a client at once. After other refusals the client tries again.

#include "client/transport/reconnector.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <set>

#include "tests/client/peer.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"

namespace feltwire::reconnector_test {
namespace {

using namespace std::chrono_literals;
using control::RefusalCode;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The first waits that it draws are longer than zero, so that no attempt begins at once.
constexpr std::uint64_t kSeed = 1;

control::JoinRequest anyone() { return {"tester", "floor", builtin_device("simulated"), {}}; }

/// Calls the reconnector with hours between the calls until it gives up or sends a request. Returns
/// the refusal.
std::string given_up(const ServerAccess& access) {
  Ring<SessionAddress> sessions(2);
  Reconnector reconnector(access, anyone(), sessions, {.timeout = 10s, .seed = kSeed});
  Reconnector::Clock::time_point now{};
  test::eventually("a refusal or a second attempt", [&] {
    reconnector.look(false, now += 1h);
    return !reconnector.refusal().empty() || reconnector.attempts() >= 2;
  });
  test::eventually("the end of the last attempt", [&] {  // The attempt runs in its own thread.
    if (!reconnector.asking()) return true;
    reconnector.look(true, now);
    return false;
  });
  SessionAddress none;
  EXPECT_FALSE(sessions.pop(none));
  if (reconnector.refusal().empty()) return {};
  EXPECT_EQ(reconnector.attempts(), 1u);
  reconnector.look(false, now += 1h);
  EXPECT_EQ(reconnector.attempts(), 1u);  // no further attempt
  return reconnector.refusal();
}

TEST(Reconnector, WhatMayHealIsWaitedOutAndTheRestEndsIt) {
  const std::set<RefusalCode> heals = {RefusalCode::full, RefusalCode::shutting_down,
                                       RefusalCode::too_many, RefusalCode::failed,
                                       RefusalCode::bad_ticket};
  for (std::uint8_t i = 0; i <= static_cast<std::uint8_t>(RefusalCode::bad_ticket); ++i) {
    const auto code = static_cast<RefusalCode>(i);
    testing::ControlPeer peer(control::encode(control::Refused{code, "for this reason"}));
    const std::string said = given_up(peer.access());
    if (heals.contains(code)) {
      EXPECT_THAT(said, IsEmpty()) << control::name(code);
    } else {
      EXPECT_THAT(said, HasSubstr("refused: for this reason")) << control::name(code);
    }
  }
}

TEST(Reconnector, AServerThatIsAwayMayComeBack) {
  std::uint16_t closed = 0;
  {
    const testing::LocalSocket socket(SOCK_STREAM);
    closed = socket.port();
  }
  EXPECT_THAT(given_up(test::access(closed)), IsEmpty());
  testing::ControlPeer silent({});
  EXPECT_THAT(given_up(silent.access()), IsEmpty());
}

TEST(Reconnector, AnotherServerInItsPlaceEndsIt) {
  testing::ControlPeer peer({});
  ServerAccess access = peer.access();
  access.credentials.trust = fingerprint(make_identity({"localhost"}));
  EXPECT_THAT(given_up(access), HasSubstr("is not the server whose fingerprint was given"));
}

TEST(Reconnector, OtherParametersEndIt) {
  control::JoinAccepted accepted;
  accepted.session = 7;
  accepted.port_offset = 1;
  accepted.silence_timeout = 2.0;
  accepted.parameters.redundancy = 2;
  testing::ControlPeer peer(control::encode(testing::with_secrets(accepted)));
  EXPECT_THAT(given_up(peer.access()),
              HasSubstr("now grants other parameters than those of the session before (redundancy: "
                        "asked 3, granted 2)"));
}

/// The bounding method changed after the request. The client must not take the granted session,
/// because this session has the old method.
TEST(Reconnector, AnAttemptUnderWayBringsNoSessionWithTheLawBefore) {
  control::JoinAccepted accepted;
  accepted.session = 7;
  accepted.port_offset = 1;
  accepted.silence_timeout = 2.0;
  for (const bool changes : {false, true}) {
    testing::ControlPeer peer(control::encode(testing::with_secrets(accepted)));
    Ring<SessionAddress> sessions(2);
    Reconnector reconnector(peer.access(), anyone(), sessions, {.timeout = 10s, .seed = kSeed});
    Reconnector::Clock::time_point now{};
    reconnector.look(false, now += 1h);  // draws the wait before the first attempt
    reconnector.look(false, now += 1h);
    ASSERT_TRUE(reconnector.asking());
    if (changes) {
      SessionParameters other;
      other.mode = "per_axis";
      reconnector.put_law(law_of(other));
    }
    test::eventually("the end of the attempt", [&] {
      reconnector.look(false, now);
      return !reconnector.asking();
    });
    SessionAddress found;
    EXPECT_EQ(sessions.pop(found), !changes);
    EXPECT_EQ(reconnector.sessions(), changes ? 0u : 1u);
    EXPECT_THAT(reconnector.refusal(), IsEmpty());
  }
}

/// An attempt without file descriptors counts as failed. The next attempt must follow.
TEST(Reconnector, WithoutDescriptorsItIsTriedAgain) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "the sanitizer itself needs descriptors to look at an object's type";
#endif
  const testing::LocalSocket lowest_free(SOCK_STREAM);
  const ServerAccess access = test::access(lowest_free.port());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{static_cast<rlim_t>(lowest_free.descriptor()) + 1, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const std::string said = given_up(access);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_THAT(said, IsEmpty());
}

}  // namespace
}  // namespace feltwire::reconnector_test
