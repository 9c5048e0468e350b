// A viewer that gets no message must still be noticed when it is gone.

#include <gtest/gtest.h>

#include <asio/io_context.hpp>

#include "protocol/net/clock.hpp"
#include "server/web/ping_schedule.hpp"
#include "server/web/viewer_hub.hpp"
#include "tests/server/web/page_fakes.hpp"
#include "tests/support/security.hpp"

namespace feltwire::web::ping_test {
namespace {

using Step = PingSchedule::Step;
constexpr Nanoseconds kBegin = std::chrono::seconds(1000);
constexpr Nanoseconds kSecond = std::chrono::seconds(1);

TEST(PingSchedule, PingsAgainAndAgainUntilTheViewerIsGone) {
  PingSchedule pings(kBegin);
  EXPECT_EQ(pings.step(kBegin + PingSchedule::kIdle - kSecond), Step::wait);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(pings.step(kBegin + i * PingSchedule::kIdle), Step::ping);
    EXPECT_EQ(pings.step(kBegin + i * PingSchedule::kIdle + kSecond), Step::wait);
  }
  EXPECT_EQ(pings.step(kBegin + PingSchedule::kGone), Step::gone);
}

TEST(PingSchedule, AFrameOfTheViewerBeginsAnew) {
  PingSchedule pings(kBegin);
  EXPECT_EQ(pings.step(kBegin + PingSchedule::kIdle), Step::ping);
  const Nanoseconds answered = kBegin + PingSchedule::kIdle + kSecond;
  pings.hear(answered);
  EXPECT_EQ(pings.step(answered + PingSchedule::kIdle - kSecond), Step::wait);
  EXPECT_EQ(pings.step(answered + PingSchedule::kIdle), Step::ping);
  EXPECT_EQ(pings.step(answered + PingSchedule::kGone), Step::gone);
}

TEST(Pings, AFoxgloveViewerThatAnswersNoneIsRefused) {
  const IssuedToken eye = issue_token("eye", "*", Role::observer, std::nullopt);
  asio::io_context io;
  test::FakeScene scene;
  ViewerHub hub(io, {&scene}, test::security({eye.token}).tokens);
  test::FakeViewer idle, page;
  const ViewerHub::Id id = hub.join(idle, asio::ip::make_address("127.0.0.1"));
  const ViewerHub::Id other = hub.join(page, asio::ip::make_address("127.0.0.1"));
  const auto minted = hub.mint_ticket(&eye.token, "");
  ASSERT_TRUE(minted);
  hub.admit(id, *hub.redeem_ticket(minted->text()));
  hub.receive(other, R"({"token":")" + std::string(eye.text.text()) + R"("})");

  const Nanoseconds now = monotonic_now();
  hub.tick(now);
  EXPECT_EQ(idle.pings, 0);
  hub.tick(now + PingSchedule::kIdle);
  EXPECT_EQ(idle.pings, 1);
  EXPECT_FALSE(idle.closed);
  hub.tick(now + PingSchedule::kGone);
  EXPECT_TRUE(idle.closed);
  // The page gets messages twice a second, so it needs no ping.
  EXPECT_EQ(page.pings, 0);
  EXPECT_FALSE(page.closed);
}

}  // namespace
}  // namespace feltwire::web::ping_test
