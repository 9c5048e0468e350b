// A ticket must work once, within a minute, for a single scene.

#include "server/web/view_tickets.hpp"

#include <gtest/gtest.h>

namespace feltwire::web {
namespace {

using std::chrono::seconds;
const CalendarTime kNow{seconds(1'700'000'000)};

Token holder(const std::string& client = "eye") {
  return issue_token(client, "*", Role::operator_, std::nullopt).token;
}

TEST(ViewTickets, OpenOneSceneOnce) {
  ViewTickets tickets;
  const Token by = holder();
  const Secret text = tickets.mint(by, "room", kNow);
  const auto opened = tickets.redeem(text.text(), kNow);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->scene, "room");
  EXPECT_EQ(opened->token, by.id);
  EXPECT_FALSE(tickets.redeem(text.text(), kNow)) << "a second time";
}

TEST(ViewTickets, AreGoodForAMinute) {
  ViewTickets tickets;
  const Secret used = tickets.mint(holder(), "room", kNow);
  EXPECT_TRUE(tickets.redeem(used.text(), kNow + ViewTickets::kLife - seconds(1)));
  const Secret old = tickets.mint(holder(), "room", kNow);
  EXPECT_FALSE(tickets.redeem(old.text(), kNow + ViewTickets::kLife + seconds(1)));
}

TEST(ViewTickets, NoOtherTextIsOne) {
  ViewTickets tickets;
  const IssuedToken by = issue_token("eye", "*", Role::admin, std::nullopt);
  const Secret text = tickets.mint(by.token, "room", kNow);
  for (const std::string& other :
       {std::string(), std::string("fw_"), std::string(text.text()) + "x",
        std::string(text.text().substr(1)), std::string(by.text.text())})
    EXPECT_FALSE(tickets.redeem(other, kNow)) << other;
  EXPECT_TRUE(tickets.redeem(text.text(), kNow)) << "wrong texts leave it good";
}

/// A single holder must not fill the memory or invalidate the tickets of others.
TEST(ViewTickets, TheOldestOfAHolderGivesWay) {
  ViewTickets tickets;
  const Token greedy = holder("greedy");
  const Secret other = tickets.mint(holder(), "room", kNow);
  const Secret first = tickets.mint(greedy, "room", kNow);
  std::vector<Secret> later;
  for (std::size_t i = 0; i < ViewTickets::kMostOfToken; ++i)
    later.push_back(tickets.mint(greedy, "room", kNow));
  EXPECT_FALSE(tickets.redeem(first.text(), kNow));
  for (const Secret& text : later) EXPECT_TRUE(tickets.redeem(text.text(), kNow));
  EXPECT_TRUE(tickets.redeem(other.text(), kNow));
}

}  // namespace
}  // namespace feltwire::web
