// The limits of requests alone: rates by the client's name, roles and counters.

#include "server/control/request_limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

namespace feltwire::request_limits_test {
namespace {

using control::RefusalCode;
using control::Refused;
using ::testing::HasSubstr;

/// Two requests at once, and no more in the time of a test.
constexpr ServiceLimits kTwo{
    .join_rate = 1e-3, .join_burst = 2.0, .request_rate = 1e-3, .request_burst = 2.0};

Token token_of(const char* client, Role role) {
  Token token;
  token.client = client;
  token.role = role;
  return token;
}

TEST(RequestLimits, EachClientHasItsOwnRate) {
  RequestLimits limits(kTwo);
  EXPECT_FALSE(limits.check_requests("anna"));
  EXPECT_FALSE(limits.check_requests("anna"));
  const std::optional<Refused> refused = limits.check_requests("anna");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::too_many);
  EXPECT_THAT(refused->reason, HasSubstr("client 'anna' asks too often"));
  EXPECT_FALSE(limits.check_requests("ben"));
  EXPECT_EQ(limits.counters().too_many, 1u);
}

TEST(RequestLimits, EachKindOfRequestHasItsOwnRate) {
  RequestLimits limits(kTwo);
  for (int n = 0; n < 2; ++n) {
    EXPECT_FALSE(limits.check_joins("anna"));
    EXPECT_FALSE(limits.check_changes("anna"));
    EXPECT_FALSE(limits.check_questions(token_of("anna", Role::observer)));
  }
  EXPECT_THAT(limits.check_joins("anna")->reason, HasSubstr("joins too often"));
  EXPECT_THAT(limits.check_changes("anna")->reason, HasSubstr("changes parameters"));
  EXPECT_THAT(limits.check_questions(token_of("anna", Role::observer))->reason,
              HasSubstr("descriptions and lists"));
  EXPECT_EQ(limits.counters().too_many, 3u);
}

TEST(RequestLimits, AnAdminMayAskForDescriptionsAtAnyRate) {
  RequestLimits limits(kTwo);
  for (int n = 0; n < 10; ++n) EXPECT_FALSE(limits.check_questions(token_of("boss", Role::admin)));
}

TEST(RequestLimits, ARoleCoversTheLowerOnes) {
  RequestLimits limits(kTwo);
  EXPECT_FALSE(limits.check_role(Role::observer, token_of("boss", Role::admin)));
  const std::optional<Refused> refused =
      limits.check_role(Role::admin, token_of("anna", Role::observer));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::forbidden);
  EXPECT_EQ(refused->reason, "this is for admins; the token is for an observer");
  EXPECT_EQ(limits.counters().forbidden, 1u);
}

TEST(RequestLimits, CountsTheRefusalsOfOthers) {
  RequestLimits limits(kTwo);
  limits.refuse(RefusalCode::unauthenticated, "no token");
  limits.refuse(RefusalCode::unknown_scene, "no such scene");
  EXPECT_EQ(limits.counters().unauthenticated, 1u);
  EXPECT_EQ(limits.counters().forbidden + limits.counters().too_many, 0u);
}

}  // namespace
}  // namespace feltwire::request_limits_test
