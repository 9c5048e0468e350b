// A server may withhold a reply that the client can compute from the last reply.

#include "server/scene/reply_deadband.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "server/scene/session.hpp"
#include "tests/server/make.hpp"

namespace feltwire::reply_deadband_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

SessionParameters deadband(double fraction, Predictor predictor = Predictor::level,
                           double keep_alive = 0.05) {
  SessionParameters p;
  p.mode = "none";
  p.force_deadband = fraction;
  p.predictor = predictor;
  p.keep_alive = keep_alive;
  validate(p);
  return p;
}

struct Sent {
  int tick;
  Reply reply;
};

/// The sent replies, and the largest relative error of the client's force above the imperceptible
/// force.
struct Played {
  std::vector<Sent> sent;
  double worst = 0.0;
};
Played play(const SessionParameters& p, const std::function<Command(double)>& scene, int ticks) {
  ReplyDeadband deadband(p);
  Played played;
  for (int n = 0; n < ticks; ++n) {
    Reply reply;
    reply.command = scene(kPeriod * n);
    deadband.add(reply.command, kPeriod);
    if (!deadband.withhold(reply)) played.sent.push_back({n, reply});
    const Sent& last = played.sent.back();
    const Command held =
        extrapolated(last.reply.command, last.reply.rates, kPeriod * (n - last.tick));
    const double off = (held.force() - reply.command.force()).norm() - kUnfeltForce;
    played.worst = std::max(played.worst, off / std::max(1e-12, reply.command.force().norm()));
    EXPECT_EQ(acts(last.reply.command), acts(reply.command)) << n;
  }
  return played;
}

/// Returns the force of five strokes: each presses, slides with a changing force, and leaves.
Command strokes(double t) {
  const double depth = std::max(0.0, std::sin(2 * M_PI * t));
  if (!(depth > 0.0)) return {};
  return {.elastic = Vec3(0.2 * depth * std::sin(9 * t), 0, 4 * depth),
          .frictional = Vec3(-0.8 * depth, 0, 0)};
}

TEST(ReplyDeadband, WhatTheClientHoldsIsWithinTheFraction) {
  std::size_t before = 0;
  for (const Predictor predictor : {Predictor::level, Predictor::linear}) {
    before = 5000;
    for (const double k : {0.02, 0.05, 0.1, 0.2}) {
      const Played played = play(deadband(k, predictor), strokes, 5000);
      EXPECT_LE(played.worst, k * (1 + 1e-9));
      EXPECT_LE(played.sent.size(), before);  // A larger fraction must send less.
      before = played.sent.size();
    }
    EXPECT_LT(before, 500u);
  }
}

TEST(ReplyDeadband, ALineNeedsFewerThanALevel) {
  const double k = 0.05;
  EXPECT_LT(
      1.5 * static_cast<double>(play(deadband(k, Predictor::linear), strokes, 5000).sent.size()),
      static_cast<double>(play(deadband(k), strokes, 5000).sent.size()));
}

TEST(ReplyDeadband, WithoutOneNothingIsWithheld) {
  SessionParameters p;
  EXPECT_EQ(play(p, strokes, 500).sent.size(), 500u);
}

TEST(ReplyDeadband, SilenceLastsKeepAliveAtMost) {
  for (const int interval : {1, 3, 7}) {
    SessionParameters p = deadband(0.1, Predictor::level, 0.02);
    p.packet_interval = interval;
    ReplyDeadband deadband(p);
    double silent = 0.0;
    int sent = 0;
    for (int n = 0; n < 1000; n += interval) {
      Reply reply;
      reply.command.elastic = Vec3(0, 0, 1);
      deadband.add(reply.command, interval * kPeriod);
      silent += interval * kPeriod;
      if (deadband.withhold(reply)) continue;
      if (n > 0) {
        EXPECT_LE(silent, 0.02 + 1e-9);
      }
      silent = 0.0;
      ++sent;
    }
    EXPECT_NEAR(sent, 1000 / (20 / interval * interval), 1);
  }
}

TEST(ReplyDeadband, WhatBeginsOrEndsIsSent) {
  const auto answered = [](const std::function<void(Reply&)>& change) {
    ReplyDeadband deadband(reply_deadband_test::deadband(0.5));
    Reply reply;
    reply.command.elastic = Vec3(0, 0, 1e-4);
    const auto next = [&](Reply r) {
      deadband.add(r.command, kPeriod);
      return !deadband.withhold(r);
    };
    EXPECT_TRUE(next(reply));
    EXPECT_FALSE(next(reply));
    Reply changed = reply;
    change(changed);
    const bool first = next(changed);
    return std::pair(first, next(changed));
  };
  EXPECT_EQ(answered([](Reply&) {}), std::pair(false, false));
  EXPECT_EQ(answered([](Reply& r) { r.command = {}; }), std::pair(true, false));
  EXPECT_EQ(answered([](Reply& r) { r.bound.refused = true; }), std::pair(true, false));
  EXPECT_EQ(answered([](Reply& r) { r.bound.saturated = true; }), std::pair(true, false));
  EXPECT_EQ(answered([](Reply& r) { r.gap = true; }), std::pair(true, true));
  EXPECT_EQ(answered([](Reply& r) { r.recovering = true; }), std::pair(true, true));
  EXPECT_EQ(answered([](Reply& r) { r.bound.active = true; }), std::pair(false, false));
}

// The server must send all replies during a recovery, and the first reply afterwards.
TEST(ReplyDeadband, NothingIsWithheldWhileWhatMovesComesBack) {
  ReplyDeadband deadband(reply_deadband_test::deadband(0.5));
  Reply reply;
  reply.command.elastic = Vec3(0, 0, 1);
  std::vector<bool> sent;
  for (const bool recovering : {false, false, true, true, true, false, false}) {
    reply.recovering = recovering;
    deadband.add(reply.command, kPeriod);
    sent.push_back(!deadband.withhold(reply));
  }
  EXPECT_EQ(sent, std::vector<bool>({true, false, true, true, true, true, false}));
}

/// Returns the model of a ball of radius 50 mm. The tool slides past outside.
LocalModel ball_model(const Vec3& tool) {
  const Vec3 up = tool.normalized();
  LocalModel model;
  model.center = tool;
  model.reach = 0.1;
  model.count = 1;
  SurfacePatch& patch = model.patches[0];
  patch.point = 0.05 * up;
  patch.normal = up;
  patch.curvature = 20.0;
  patch.radius = 0.1;
  patch.material.stiffness = 1000.0;
  return model;
}

TEST(ReplyDeadband, AModelThatStillHoldsNeedNotBeSentAgain) {
  const LocalModel sent = ball_model(Vec3(0, 0, 0.048));
  const Vec3 aside(0.02, 0, 0.04);
  EXPECT_TRUE(describes(sent, sent, 0.01, 1e-6));
  EXPECT_TRUE(describes(sent, ball_model(aside), 0.01, 1e-6));  // The tool is on the same ball.
  LocalModel flat = sent;
  flat.patches[0].curvature = 0.0;
  EXPECT_FALSE(describes(flat, ball_model(aside), 0.01, 1e-6));
  // half of the valid radius
  EXPECT_FALSE(describes(sent, ball_model(Vec3(0, 0, 0.10)), 0.01, 1.0));

  const auto changed = [&](const std::function<void(LocalModel&)>& change) {
    LocalModel now = ball_model(aside);
    change(now);
    return !describes(sent, now, 0.01, 0.1);
  };
  EXPECT_FALSE(changed([](LocalModel& m) { m.patches[0].point *= 1.0015; }));  // 75 um of 100 um
  EXPECT_TRUE(changed([](LocalModel& m) { m.patches[0].point *= 1.003; }));
  EXPECT_TRUE(changed([](LocalModel& m) { m.patches[0].feature = 1; }));
  EXPECT_TRUE(changed([](LocalModel& m) { m.patches[0].joined = true; }));
  EXPECT_TRUE(changed([](LocalModel& m) { m.center.x() = std::nan(""); }));
  LocalModel narrow = sent;
  narrow.patches[0].radius = 0.03;
  EXPECT_FALSE(describes(narrow, ball_model(aside), 0.01, 1.0));
  EXPECT_FALSE(describes(LocalModel{}, ball_model(aside), 0.01, 1.0));

  // A new surface must matter within the valid radius of the sent model, but not beyond.
  LocalModel more = ball_model(aside);
  more.patches[1] = more.patches[0];
  more.patches[1].object = 1;
  more.count = 2;
  more.patches[1].point = Vec3(0.09, 0, 0.048);
  EXPECT_FALSE(describes(sent, more, 0.01, 1.0));
  more.patches[1].point = Vec3(0.11, 0, 0.048);
  EXPECT_TRUE(describes(sent, more, 0.01, 1.0));

  // The surface moved as its sent velocity predicts.
  LocalModel moving = sent, later = sent;
  moving.patches[0].velocity = Vec3(0, 0, 0.5);
  later.patches[0].point.z() += 5e-3;
  EXPECT_TRUE(describes(moving, later, 0.01, 1e-6));
  EXPECT_FALSE(describes(moving, sent, 0.01, 1.0));
}

/// In free space the force gives no reason to send a reply, but an approaching wall does.
TEST(ReplyDeadband, AModelIsRenewedBeforeTheToolLeavesIt) {
  SessionParameters p = deadband(0.1, Predictor::level, 0.05);
  p.side = BoundingSide::client;
  p.local_model = true;
  validate(p);
  ReplyDeadband deadband(p);
  Vec3 told = Vec3::Zero();
  int sent = 0;
  for (int n = 0; n < 400; ++n) {
    Reply reply;
    reply.modelled = true;
    reply.model = ball_model(Vec3(0, 0, 0.5 - 0.002 * n));
    reply.model.count = 0;
    deadband.add({}, kPeriod);
    if (!deadband.withhold(reply)) {
      told = reply.model.center;
      ++sent;
    }
    ASSERT_LT((reply.model.center - told).norm(), 0.5 * reply.model.reach);
  }
  EXPECT_LT(sent, 25);
}

/// A complete session must count withheld replies and report the count in the next reply.
TEST(SessionDeadband, CountsWhatItWithholdsAndSaysSo) {
  const Scene scene = test::room(0.0);
  Session session(test::join_request(deadband(0.1)), scene);
  SampleBatch batch = test::hand_batch(1);
  std::uint64_t withheld = 0;
  for (std::uint64_t n = 1; n <= 400; ++n) {
    batch = test::hand_batch(n);
    batch.samples[0].pose.position = Vec3(-0.1, 0, -0.002 - 1e-6 * static_cast<double>(n));
    const BatchResult taken = session.take(batch, Nanoseconds(0));
    ASSERT_EQ(taken.drop, DropReason::none);
    withheld += taken.withheld ? 1 : 0;
    EXPECT_EQ(taken.reply.withheld, withheld);
  }
  EXPECT_GT(withheld, 380u);
  EXPECT_EQ(session.counters().withheld, withheld);
  EXPECT_EQ(session.counters().replies, 400 - withheld);
  EXPECT_EQ(session.counters().samples, 400u);
}

TEST(SessionDeadband, RatesTravelWithALineOnly) {
  const Scene scene = test::room(0.0);
  for (const Predictor predictor : {Predictor::level, Predictor::linear}) {
    Session session(test::join_request(deadband(0.1, predictor)), scene);
    Reply last;
    for (std::uint64_t n = 1; n <= 40; ++n) {
      SampleBatch batch = test::hand_batch(n);
      batch.samples[0].pose.position = Vec3(-0.1, 0, -1e-4 * static_cast<double>(n));
      const BatchResult taken = session.take(batch, Nanoseconds(0));
      EXPECT_EQ(taken.reply.predicted, predictor == Predictor::linear);
      last = taken.reply;
    }
    EXPECT_NEAR(last.rates.elastic.z(), predictor == Predictor::linear ? 200.0 : 0.0, 1e-6);
  }
}

/// Omitted samples of the client are no gap and count as a single hold. A lost sample is a gap.
TEST(Session, LeftOutIsNotLost) {
  const Scene scene = test::room(0.0);
  Session session(test::join_request(), scene);
  const auto take = [&](std::uint64_t index, std::uint64_t previous) {
    SampleBatch batch = test::hand_batch(index);
    batch.previous = previous;
    return session.take(batch, Nanoseconds(0)).reply.gap;
  };
  EXPECT_FALSE(take(4, 0));
  EXPECT_FALSE(take(9, 4));
  EXPECT_EQ(session.counters().gaps, 0u);
  EXPECT_TRUE(take(19, 14));
  EXPECT_EQ(session.counters().gaps, 1u);
  EXPECT_EQ(session.counters().missed, 5u);
  EXPECT_FALSE(take(24, 19));
  EXPECT_TRUE(take(27, 26));
  EXPECT_EQ(session.counters().missed, 7u);
  EXPECT_EQ(session.counters().samples, 5u);
}

}  // namespace
}  // namespace feltwire::reply_deadband_test
