// Tests the parameters that a server may grant to a client.

#include "protocol/session/grant.hpp"

#include <gmock/gmock.h>

#include <set>

#include "protocol/session/client_change.hpp"
#include "protocol/session/profiles.hpp"
#include "tests/protocol/parameter_changes.hpp"

namespace feltwire::grant_test {
namespace {

using ::testing::Optional;
using ::testing::StartsWith;

std::set<std::string> fields(bool permitted) {
  std::set<std::string> names;
  for (const auto& change : test::parameter_changes())
    if (change.permitted == permitted) names.insert(change.field);
  return names;
}

std::set<std::string> rules(bool may_differ) {
  std::set<std::string> names;
  std::apply(
      [&](const auto&... rule) {
        ((may_differ && rule.may_grant == nullptr ? void() : void(names.insert(rule.field))), ...);
      },
      kParameterRules);
  return names;
}

TEST(Grant, EachFieldIsTriedAndHasOneRule) {
  EXPECT_EQ(rules(false).size(), kParameterFields);
  std::set<std::string> tried = fields(false);
  tried.merge(fields(true));
  EXPECT_EQ(tried, rules(false));
  EXPECT_EQ(fields(true), rules(true));
}

TEST(Grant, EachChangeIsOfItsFieldAloneAndJudgedByItsRule) {
  for (const auto& change : test::parameter_changes()) {
    EXPECT_NO_THROW(validate(change.asked));
    EXPECT_NO_THROW(validate(change.granted));
    EXPECT_THAT(difference(change.asked, change.granted), Optional(StartsWith(change.field + ": ")))
        << change.field;
    EXPECT_EQ(forbidden_grant(change.asked, change.granted).has_value(), !change.permitted)
        << difference(change.asked, change.granted).value_or("equal");
    EXPECT_EQ(difference(change.granted, change.granted), std::nullopt);
    EXPECT_EQ(forbidden_grant(change.granted, change.granted), std::nullopt);
  }
}

TEST(Grant, ADifferenceIsNamedWithBothValues) {
  SessionParameters asked, granted;
  granted.operator_damping = 100.0;
  EXPECT_EQ(forbidden_grant(asked, granted), "operator_damping: asked 0, granted 100");
  granted = {};
  granted.c1 = 400.5;
  EXPECT_EQ(forbidden_grant(asked, granted), "c1: asked not given, granted 400.5");
  granted = {};
  granted.mode = "none";
  EXPECT_EQ(forbidden_grant(asked, granted), "mode: asked contact_frame, granted none");
  granted.mode = "none\x1b[2J";  // A foreign server may send this.
  EXPECT_EQ(forbidden_grant(asked, granted), "mode: asked contact_frame, granted none\\x1b[2J");
  granted = {};
  granted.local_model = true;
  EXPECT_EQ(difference(asked, granted), "local_model: asked off, granted on");
}

// A permitted change must not hide a forbidden one.
TEST(Grant, AForbiddenFieldIsFoundAmongThoseThatMayDiffer) {
  for (const auto& change : test::parameter_changes()) {
    if (change.permitted) continue;
    SessionParameters granted = change.granted;
    granted.redundancy = 1;
    granted.force_deadband = 0.1;
    EXPECT_THAT(forbidden_grant(change.asked, granted), Optional(StartsWith(change.field + ": ")));
  }
}

// A longer hold time keeps a force longer. The client's owner sets the limit.
TEST(Grant, AHoldTimeIsLengthenedAsFarAsTheClientsOwnerAllows) {
  SessionParameters asked, granted;
  for (const double hold_time : {0.10001, 0.2, 0.8, 1.0}) {
    granted.hold_time = hold_time;
    EXPECT_THAT(forbidden_grant(asked, granted), Optional(StartsWith("hold_time: asked 0.1, ")));
    EXPECT_EQ(forbidden_grant(asked, granted, {.hold_time = hold_time}), std::nullopt);
    EXPECT_THAT(forbidden_grant(asked, granted, {.hold_time = 0.999 * hold_time}),
                Optional(StartsWith("hold_time: asked 0.1, ")));
  }
  granted.hold_time = 0.1;
  EXPECT_EQ(forbidden_grant(asked, granted, {.hold_time = 0.05}), std::nullopt);
}

// No change may lengthen the hold time during a session. The client must refuse such a request of a
// server. A change of the bounding method has no such field.
TEST(Grant, NoLaterChangeLengthensAHoldTime) {
  SessionParameters running, wanted;
  wanted.hold_time = 0.8;
  EXPECT_THAT(forbidden_change(running, wanted), Optional(StartsWith("hold_time: ")));
  const LawChoice law{MethodName("contact_frame"), Projection::joint, Storage::elastic};
  EXPECT_EQ(with_law(running, law).hold_time, running.hold_time);
}

// An honest server with a thin line must keep the rules at every servo rate. For a longer hold time
// the server may need the permission of the client's owner.
TEST(Grant, WhatOurServersGrantIsPermitted) {
  for (const NetworkProfile& line : kNetworkProfiles)
    for (const double rate : {10.0, 100.0, 250.0, 1000.0, 4000.0, 1e4, 1e5})
      for (const std::string_view mode : bounding_method_names())
        for (const BoundingSide side :
             {BoundingSide::server, BoundingSide::client, BoundingSide::both})
          for (const double hold_time : {0.02, 0.1, 0.3, 1.0}) {
            SessionParameters asked;
            asked.mode = mode;
            const BoundingMethod& method = bounding_method(mode);
            asked.side = stands_beside_scene(method) ? BoundingSide::server
                         : method.shapes             ? BoundingSide::client
                                                     : side;
            asked.servo_period = 1.0 / rate;
            asked.hold_time = std::max(hold_time, asked.servo_period);
            const SessionParameters given = granted(line, asked);
            EXPECT_EQ(forbidden_grant(asked, given, {.hold_time = kLongestGrantedHold}),
                      std::nullopt)
                << line.name << ' ' << rate << ' ' << asked.mode << ' ' << hold_time;
            // A second grant, to a client that lost its session, must change nothing.
            EXPECT_EQ(granted(line, given), given);
          }
}

}  // namespace
}  // namespace feltwire::grant_test
