// A lost session: since when, why, and what finds it again.

#include "client/servo/lost_session.hpp"

#include <gtest/gtest.h>

#include "client/servo/requested_changes.hpp"

namespace feltwire::lost_session_test {
namespace {

using std::chrono::milliseconds;

TEST(LostSession, OnlyAnAnswerAfterTheLossFindsIt) {
  LostSession session(milliseconds(0));
  session.heard(milliseconds(10));
  EXPECT_EQ(session.silent_for(milliseconds(60)), milliseconds(50));
  EXPECT_TRUE(session.lose(milliseconds(60), EndReason::server_silent));
  EXPECT_FALSE(session.lose(milliseconds(80), EndReason::server_goodbye)) << "it was lost before";
  EXPECT_EQ(session.lost_by(), EndReason::server_silent);
  EXPECT_EQ(session.lost_for(milliseconds(90)), milliseconds(30));
  EXPECT_FALSE(session.answered_again());
  session.heard(milliseconds(100));
  EXPECT_TRUE(session.answered_again());
  EXPECT_TRUE(session.found());
  EXPECT_FALSE(session.lost());
  EXPECT_FALSE(session.found());
}

TEST(LostSession, LooksForAnotherRouteOnceASecondToAServerThatIsSilent) {
  LostSession session(milliseconds(0));
  EXPECT_FALSE(session.may_reroute(milliseconds(5))) << "it is not lost";
  session.lose(milliseconds(10), EndReason::server_silent);
  EXPECT_TRUE(session.may_reroute(milliseconds(10)));
  EXPECT_FALSE(session.may_reroute(milliseconds(1009)));
  EXPECT_TRUE(session.may_reroute(milliseconds(1010)));
  session.server_leaves();
  EXPECT_FALSE(session.may_reroute(milliseconds(2500))) << "the server said goodbye";
}

TEST(RequestedChanges, EachIsHeardOnceAndAnsweredToItsOwnSession) {
  RequestedChanges requested;
  Ring<WantedChange> queue(4);
  ClientChange change;
  change.number = 1;
  requested.hear(change, queue);
  requested.hear(change, queue);
  WantedChange wanted;
  ASSERT_TRUE(queue.pop(wanted));
  EXPECT_FALSE(queue.pop(wanted)) << "a repeated request";

  requested.next_session();
  requested.begin_anew();
  HandReport report;
  PreparedChange prepared;
  prepared.number = 1;
  prepared.refused = true;
  EXPECT_FALSE(requested.answered(prepared));
  requested.tell(report);
  EXPECT_EQ(report.change, 0) << "this server does not know the change";
  requested.hear(change, queue);
  ASSERT_TRUE(queue.pop(wanted));
  EXPECT_EQ(wanted.session, 1u);
  prepared.session = 1;
  EXPECT_TRUE(requested.answered(prepared));
  requested.tell(report);
  EXPECT_EQ(report.change, 1);
  EXPECT_TRUE(report.change_refused);
}

}  // namespace
}  // namespace feltwire::lost_session_test
