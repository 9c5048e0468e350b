// Tests the second stage of a tick alone. This stage selects the newest reply and counts replies.

#include "client/servo/reply_intake.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace feltwire::reply_intake_test {
namespace {

constexpr double kPeriod = 1e-3, kHold = 0.1;  // [s]

/// Sends a sample each millisecond. Each sample is the newest of its datagram.
struct Intake {
  explicit Intake(bool point = false) : intake(kPeriod, point) {}
  void sample() {
    ++samples;
    now += std::chrono::milliseconds(1);
    intake.made(samples, now);
    intake.sent(samples, counts);
  }
  static Reply reply(std::uint64_t sample, double force) {
    Reply reply;
    reply.sample_index = sample;
    reply.command.elastic = Vec3(0, 0, force);
    return reply;
  }
  ReplyIntake::Taken take(const Reply& reply, bool fades = false) {
    return intake.take(reply, now, {samples, now, fades}, kHold, counts);
  }
  ReplyIntake intake;
  ReplyCounts counts;
  std::uint64_t samples = 0;
  Nanoseconds now{1'000'000'000};
};

TEST(ReplyIntake, TheNewestSampleWins) {
  Intake all;
  for (int n = 0; n < 5; ++n) all.sample();
  EXPECT_TRUE(all.take(Intake::reply(4, 2.0)).used);
  const ReplyIntake::Taken old = all.take(Intake::reply(2, 9.0));
  EXPECT_FALSE(old.newest);
  EXPECT_EQ(all.intake.newest().command.elastic.z(), 2.0);
  EXPECT_EQ(all.counts.stale, 1u);
  EXPECT_EQ(all.counts.answered, 2u) << "a late answer is an answer";
  EXPECT_EQ(all.intake.lost_so_far(all.counts), 2u) << "1 and 3";
}

TEST(ReplyIntake, RefusesWhatNobodyAskedForAndWhatIsNoForce) {
  Intake all;
  all.sample();
  EXPECT_FALSE(all.take(Intake::reply(0, 1.0)).newest);
  EXPECT_FALSE(all.take(Intake::reply(2, 1.0)).newest);
  EXPECT_FALSE(all.take(Intake::reply(1, std::numeric_limits<double>::infinity())).newest);
  EXPECT_EQ(all.counts.refused, 3u);
  EXPECT_FALSE(all.intake.has_reply());
}

TEST(ReplyIntake, TellsAgeAndRoundTrip) {
  Intake all;
  for (int n = 0; n < 10; ++n) all.sample();
  all.take(Intake::reply(7, 1.0));  // The reply's sample is 3 ms old.
  EXPECT_NEAR(all.intake.round_trip(), 3e-3, 1e-12);
  EXPECT_NEAR(all.intake.age(all.now + std::chrono::milliseconds(4)), 4e-3, 1e-12);
  EXPECT_EQ(all.counts.late, 1u);
}

/// After a pause the arrival time of a reply is unknown. The stage must assume the oldest possible
/// reply.
TEST(ReplyIntake, AReplyFromBeforeAPauseIsOutOfDate) {
  Intake all;
  all.sample();
  all.intake.stood_still(all.samples);
  all.take(Intake::reply(1, 1.0));
  EXPECT_NEAR(all.intake.age(all.now), kHold, 1e-12);
}

TEST(ReplyIntake, AFadeKeepsItsCommand) {
  Intake all;
  all.sample();
  all.take(Intake::reply(1, 1.0));
  all.sample();
  const ReplyIntake::Taken taken = all.take(Intake::reply(2, 5.0), true);
  EXPECT_TRUE(taken.newest);
  EXPECT_FALSE(taken.used);
  EXPECT_EQ(all.intake.newest().command.elastic.z(), 1.0);
  all.intake.forget_command();
  EXPECT_TRUE(all.intake.newest().command.force().isZero(0.0));
}

TEST(ReplyIntake, OnlyTheScenesOwnCommandOfThisContactIsOriginal) {
  Intake all;
  all.sample();
  all.take(Intake::reply(1, 1.0));
  EXPECT_TRUE(all.intake.original());
  all.sample();
  Reply bounded = Intake::reply(2, 1.0);
  bounded.bound.active = true;
  all.take(bounded);
  EXPECT_FALSE(all.intake.original());
  all.sample();
  all.intake.begin_anew(3);
  all.take(Intake::reply(3, 1.0));
  EXPECT_FALSE(all.intake.original());
  all.sample();
  all.take(Intake::reply(4, 1.0));
  EXPECT_TRUE(all.intake.original());
}

TEST(ReplyIntake, ANewSceneIsToldOnceAndNotForAnotherSession) {
  Intake all;
  all.sample();
  EXPECT_FALSE(all.take(Intake::reply(1, 0.0)).scene_changed);
  all.sample();
  Reply reloaded = Intake::reply(2, 0.0);
  reloaded.reloads = 1;
  EXPECT_TRUE(all.take(reloaded).scene_changed);
  all.sample();
  reloaded.sample_index = 3;
  EXPECT_FALSE(all.take(reloaded).scene_changed);
  all.sample();
  all.intake.another_session(all.counts);
  EXPECT_FALSE(all.take(Intake::reply(4, 0.0)).scene_changed) << "it counts from zero";
}

TEST(ReplyIntake, ExtrapolatesForTheKeepAliveAtMost) {
  Intake all;
  all.sample();
  Reply predicted = Intake::reply(1, 1.0);
  predicted.predicted = true;
  predicted.rates.elastic = Vec3(0, 0, 10.0);  // [N/s]
  all.take(predicted);
  const auto force = [&](int milliseconds) {
    return all.intake.command(all.now + std::chrono::milliseconds(milliseconds), 0.05).elastic.z();
  };
  EXPECT_NEAR(force(20), 1.2, 1e-9);
  EXPECT_NEAR(force(500), 1.5, 1e-9);
}

/// A client that leads a robot has a point as its tool.
TEST(ReplyIntake, APointReadsNoModelOfABody) {
  Intake body, point(true);
  for (Intake* all : {&body, &point}) {
    all->sample();
    Reply reply = Intake::reply(1, 1.0);
    reply.body_modelled = true;
    all->take(reply);
  }
  EXPECT_TRUE(body.intake.newest().body_modelled);
  EXPECT_FALSE(point.intake.newest().body_modelled);
}

TEST(ReplyIntake, WithheldAnswersAreNotLost) {
  Intake all;
  for (int n = 0; n < 10; ++n) all.sample();
  Reply reply = Intake::reply(10, 1.0);
  reply.withheld = 6;
  all.take(reply);
  EXPECT_EQ(all.intake.lost_so_far(all.counts), 3u);
  reply.sample_index = 11;
  reply.withheld = 1000;  // an impossible count
  all.sample();
  all.take(reply);
  EXPECT_EQ(all.counts.withheld, all.counts.datagrams);
  EXPECT_EQ(all.intake.lost_so_far(all.counts), 0u);
}

}  // namespace
}  // namespace feltwire::reply_intake_test
