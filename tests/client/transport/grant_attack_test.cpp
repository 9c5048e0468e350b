// A trusted server grants a session that differs from the client's request.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <thread>

#include "client/transport/reconnector.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/protocol/parameter_changes.hpp"
#include "tests/support/security.hpp"

namespace feltwire::grant_attack_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::ControlPeer;
using testing::error_of;
using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kPatience{10'000};

control::JoinRequest request(const SessionParameters& parameters = {}) {
  return {.client = "tester",
          .scene = "wall",
          .device = builtin_device("simulated"),
          .parameters = parameters};
}

control::JoinAccepted offer(const SessionParameters& parameters = {}) {
  control::JoinAccepted offered;
  offered.session = 77;
  offered.port_offset = 1;
  offered.silence_timeout = 2.0;
  offered.parameters = parameters;
  return testing::with_secrets(offered);
}

/// Returns the error of join() for an offer, or an empty text if join() accepts the offer.
std::string said_of(const control::JoinAccepted& offered, const control::JoinRequest& wanted,
                    const GrantLimits& limits = {}) {
  ControlPeer peer(control::encode(offered));
  try {
    join(peer.access(), wanted, kPatience, limits);
  } catch (const LastingError& error) {
    return error.what();
  }
  return {};
}

TEST(LyingServer, AGrantBeyondTheRulesIsRefusedForGoodWithItsField) {
  for (const auto& change : test::parameter_changes()) {
    const std::string said = said_of(offer(change.granted), request(change.asked));
    const std::string what = difference(change.asked, change.granted).value();
    if (change.permitted)
      EXPECT_EQ(said, "") << what;
    else
      EXPECT_THAT(said, AllOf(HasSubstr("127.0.0.1:"), HasSubstr(what)));
  }
}

TEST(LyingServer, AnOfferThatNoServerMakesIsRefusedForGood) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  struct Lie {
    const char* field;
    std::function<void(control::JoinAccepted&)> tell;
  };
  std::vector<Lie> lies;
  for (const double wrong : {0.0, -0.0, -1.0, 0.099, 3600.1, 1e300, nan, infinity, -infinity})
    lies.push_back({"silence_timeout", [=](auto& o) { o.silence_timeout = wrong; }});
  for (const double wrong : {-1e-300, -1.0, 1.001e9, 1e300, nan, infinity})
    lies.push_back({"stiffness", [=](auto& o) { o.stiffness = wrong; }});
  for (const double wrong : {1000.1, -1000.1, 1e300, nan, infinity, -infinity})
    for (int axis = 0; axis < 3; ++axis)
      lies.push_back({"start_position", [=](auto& o) { o.start_position[axis] = wrong; }});
  for (const Vec3& wrong :
       {Vec3(0, 0, 0), Vec3(0, 0, 1.1), Vec3(0, 0, 0.9), Vec3(nan, 0, 1), Vec3(infinity, 0, 0)})
    lies.push_back({"start_normal", [=](auto& o) { o.start_normal = wrong; }});
  lies.push_back({"hold_time", [](auto& o) { o.parameters.hold_time = -1.0; }});
  lies.push_back({"redundancy", [](auto& o) { o.parameters.redundancy = 200; }});
  lies.push_back({"keep_alive", [](auto& o) { o.parameters.keep_alive = 1e300; }});
  for (const Lie& lie : lies) {
    control::JoinAccepted offered = offer();
    lie.tell(offered);
    EXPECT_THAT(said_of(offered, request()), HasSubstr(lie.field));
  }

  control::JoinAccepted at_limits = offer();
  for (const double good : {0.1, 3600.0}) {
    at_limits.silence_timeout = good;
    at_limits.stiffness = good == 0.1 ? 0.0 : 1e9;
    at_limits.start_position = Vec3::Constant(good == 0.1 ? -1000.0 : 1000.0);
    at_limits.start_normal = Vec3(0.6, 0.0, good == 0.1 ? 0.8 : -0.8);
    EXPECT_EQ(said_of(at_limits, request()), "");
  }
}

TEST(LyingServer, ALongerHoldTimeIsRefusedWithTheOptionThatAllowsIt) {
  SessionParameters longer;
  longer.hold_time = 0.3;
  EXPECT_THAT(
      said_of(offer(longer), request()),
      AllOf(HasSubstr("hold_time: asked 0.1, granted 0.3"), HasSubstr("--longest-hold-time")));
  EXPECT_EQ(said_of(offer(longer), request(), {.hold_time = 0.3}), "");
  longer.mode = "none";  // The option applies only to a bounded mode.
  EXPECT_THAT(said_of(offer(longer), request(), {.hold_time = 0.3}), HasSubstr("mode: "));
}

TEST(LyingServer, ASessionWithoutANumberIsNone) {
  control::JoinAccepted offered = offer();
  offered.session = 0;
  ControlPeer peer(control::encode(offered));
  EXPECT_THAT(error_of<SessionError>([&] { join(peer.access(), request(), kPatience); }),
              HasSubstr("no feltwire message"));
}

// A hand's loop keeps its parameters. A rejoined session must have all of them, including
// parameters that a first join leaves to the server.
TEST(LyingServer, ASessionJoinedAnewHasTheParametersOfTheOneBefore) {
  for (const auto& change : test::parameter_changes()) {
    ControlPeer peer(control::encode(offer(change.granted)));
    Ring<SessionAddress> sessions(2);
    Reconnector reconnector(peer.access(), request(change.asked), sessions,
                            {.timeout = 10s, .seed = 1});
    reconnector.look(false, Reconnector::Clock::time_point(1h));  // draws the first wait
    reconnector.look(false, Reconnector::Clock::time_point(2h));
    while (reconnector.asking()) {
      reconnector.look(false, Reconnector::Clock::time_point(2h));
      std::this_thread::yield();
    }
    EXPECT_THAT(reconnector.refusal(), HasSubstr(difference(change.asked, change.granted).value()));
    SessionAddress none;
    EXPECT_FALSE(sessions.pop(none)) << change.field;
  }
}

}  // namespace
}  // namespace feltwire::grant_attack_test
