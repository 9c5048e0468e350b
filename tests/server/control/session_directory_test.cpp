// The list of sessions alone: whose they are, who may see them, and who may come back.

#include "server/control/session_directory.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "server/control/request_limits.hpp"

namespace feltwire::session_directory_test {
namespace {

using namespace std::chrono_literals;

ListedSession session(const char* token, const char* client, std::size_t scene = 0,
                      Role role = Role::operator_) {
  return {.token = token,
          .client = client,
          .tool = "",
          .scene = scene,
          .scene_name = scene == 0 ? "room" : "hall",
          .role = role,
          .who = client,
          .fetches = TokenBucket(1.0, 1.0)};
}

Token token(const char* id, Role role, const char* scene = "*") {
  Token made;
  made.id = id;
  made.client = "anna";
  made.scene = scene;
  made.role = role;
  return made;
}

TEST(SessionDirectory, ASessionIsItsTokensOrAnAdminsOfItsScene) {
  SessionDirectory directory;
  directory.enter(1, session("a", "anna"));
  EXPECT_NE(directory.find_own(token("a", Role::operator_), 1), nullptr);
  EXPECT_EQ(directory.find_own(token("b", Role::operator_), 1), nullptr);
  EXPECT_NE(directory.find_own(token("b", Role::admin), 1), nullptr);
  EXPECT_EQ(directory.find_own(token("b", Role::admin, "hall"), 1), nullptr);
  EXPECT_EQ(directory.find_own(token("a", Role::operator_), 2), nullptr);
  EXPECT_EQ(directory.find_open(token("a", Role::admin, "hall"), 1), nullptr);
}

TEST(SessionDirectory, CountsByClientAndRole) {
  SessionDirectory directory;
  directory.enter(1, session("a", "anna"));
  directory.enter(2, session("b", "anna", 1, Role::pointer));
  directory.enter(3, session("c", "ben", 1, Role::pointer));
  EXPECT_EQ(directory.sessions_of("anna"), 2u);
  EXPECT_EQ(directory.sessions_of("carl"), 0u);
  EXPECT_EQ(directory.pointers(), 2u);
  directory.erase(3);
  EXPECT_EQ(directory.pointers(), 1u);
}

TEST(SessionDirectory, ListsTheScenesThatATokenOpensPageByPage) {
  SessionDirectory directory;
  const std::uint64_t most = control::kMaxSessionEntries;
  for (std::uint64_t id = 1; id <= most + 1; ++id) directory.enter(id, session("a", "anna"));
  directory.enter(most + 2, session("b", "ben", 1));
  control::SessionList list = directory.list(token("x", Role::admin, "room"), 0);
  EXPECT_EQ(list.sessions.size(), most);
  EXPECT_TRUE(list.more);
  list = directory.list(token("x", Role::admin, "room"), most);
  ASSERT_EQ(list.sessions.size(), 1u);
  EXPECT_EQ(list.sessions[0].session, most + 1);
  EXPECT_FALSE(list.more);
  EXPECT_EQ(directory.list(token("x", Role::admin), most).sessions.size(), 2u);
}

TEST(SessionDirectory, AClientThatBrokeASceneWaitsBeforeThatScene) {
  SessionDirectory directory;
  directory.enter(1, session("a", "anna"));
  directory.enter(2, session("b", "ben"));
  directory.forget({{1, SessionEnd::disturbing}, {2, SessionEnd::goodbye}, {7, SessionEnd::silent}},
                   10s);
  EXPECT_TRUE(directory.sessions().empty());
  EXPECT_TRUE(directory.has_disturbed("anna", 0, 10s));
  EXPECT_FALSE(directory.has_disturbed("anna", 1, 10s));
  EXPECT_FALSE(directory.has_disturbed("ben", 0, 10s));
  EXPECT_FALSE(directory.has_disturbed("anna", 0, 10s + ServiceLimits::kDisturberPause));
}

}  // namespace
}  // namespace feltwire::session_directory_test
