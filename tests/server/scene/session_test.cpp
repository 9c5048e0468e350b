#include "server/scene/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "tests/server/make.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::session_test {
namespace {

using test::hand;
using test::hand_batch;
using test::join_request;

constexpr Nanoseconds kNow{1000};

Reply take(Session& session, const SampleBatch& batch) {
  const BatchResult taken = session.take(batch, kNow);
  EXPECT_EQ(taken.drop, DropReason::none);
  return taken.reply;
}

void expect_same_forces(const Reply& a, const Reply& b) {
  EXPECT_EQ(a.command.elastic, b.command.elastic);
  EXPECT_EQ(a.command.frictional, b.command.frictional);
  EXPECT_EQ(a.bound.ratio, b.bound.ratio);
  EXPECT_EQ(a.bound.active, b.bound.active);
}

TEST(Session, AnswersTheNewestSample) {
  const Scene scene = test::room();
  Session session(join_request(), scene);
  const Reply reply = take(session, hand_batch(7, 3));
  EXPECT_EQ(reply.sample_index, 7u);
  EXPECT_EQ(reply.client_time, hand(7).client_time);
  EXPECT_EQ(reply.server_times.received, kNow);
  EXPECT_FALSE(reply.rotation);
  EXPECT_FALSE(reply.gap);
  EXPECT_EQ(session.counters().samples, 4u);
  EXPECT_EQ(session.counters().replies, 1u);
}

/// A pressed floor without a bound must give k d.
TEST(Session, CommandsTheScenesForce) {
  const Scene scene = test::room(0.0);
  SessionParameters raw = test::server_bounds();
  raw.mode = "none";
  Session session(join_request(raw), scene);
  Sample sample = hand(1);
  sample.pose.position = {-0.1, 0, -0.004};
  SampleBatch batch;
  batch.count = 1;
  batch.samples[0] = sample;
  const Reply reply = take(session, batch);
  EXPECT_NEAR(reply.command.elastic.z(), 2000 * 0.004, 1e-9);
  EXPECT_EQ(reply.bound.ratio, 1.0);
  EXPECT_FALSE(reply.bound.active);
}

TEST(Session, TwoDegreesOfFreedomGetNoThirdForce) {
  const Scene scene = test::room();
  auto request = join_request();
  request.device.translation_dof = 2;
  request.parameters.mode = "none";
  Session session(request, scene);
  SampleBatch batch = hand_batch(1);
  batch.samples[0].pose.position = {-0.1, 0, -0.004};
  EXPECT_EQ(take(session, batch).command.elastic, Vec3::Zero());
}

TEST(Session, NothingNewIsStaleAndChangesNothing) {
  const Scene scene = test::room();
  Session session(join_request(), scene), untroubled(join_request(), scene);
  take(session, hand_batch(5, 3));
  take(untroubled, hand_batch(5, 3));
  EXPECT_EQ(session.take(hand_batch(5, 3), kNow).drop, DropReason::stale);
  EXPECT_EQ(session.take(hand_batch(4, 0), kNow).drop, DropReason::stale);
  EXPECT_EQ(session.counters().duplicates, 2u);
  EXPECT_EQ(session.counters().samples, 4u);
  expect_same_forces(take(session, hand_batch(6, 3)), take(untroubled, hand_batch(6, 3)));
}

/// Up to k datagrams in a row are lost, with k repeated samples. The forces must equal those of a
/// perfect link bitwise, even with reordering and duplicates.
TEST(Session, RedundancyClosesGapsExactly) {
  for (const std::string_view mode : {"contact_frame", "per_axis_projected", "total_energy"}) {
    const Scene scene = test::room();
    SessionParameters parameters = test::server_bounds();
    parameters.mode = mode;
    Session whole(join_request(parameters), scene), lossy(join_request(parameters), scene);
    test::Generator random(3);
    int lost = 0, compared = 0;
    for (std::uint64_t n = 1; n <= 4000; ++n) {
      const Reply expected = take(whole, hand_batch(n));
      if (lost < 3 && random() % 3 == 0) {
        ++lost;
        continue;
      }
      lost = 0;
      const Reply got = take(lossy, hand_batch(n, 3));
      expect_same_forces(got, expected);
      EXPECT_FALSE(got.gap);
      EXPECT_EQ(got.delivered.elastic, expected.delivered.elastic);
      ++compared;
      if (random() % 4 == 0) {
        EXPECT_EQ(lossy.take(hand_batch(n, 3), kNow).drop, DropReason::stale);
      }
      if (n > 5 && random() % 4 == 0) {
        EXPECT_EQ(lossy.take(hand_batch(n - 1, 3), kNow).drop, DropReason::stale);
      }
    }
    EXPECT_GT(compared, 2000);
    EXPECT_EQ(lossy.counters().gaps, 0u);
  }
}

/// A gap must be a single bounding step with its complete displacement and time.
TEST(Session, GapIsAccountedAsOneLongHold) {
  const Scene scene = test::room(0.0);
  Session session(join_request(), scene);
  auto batch_at = [](std::uint64_t index, double depth) {
    SampleBatch batch = hand_batch(index);
    batch.samples[0].pose.position = {-0.1, 0, -depth};
    return batch;
  };
  take(session, batch_at(1, 0.0));
  const Reply before = take(session, batch_at(2, 1e-4));
  const Reply after = take(session, batch_at(7, 6e-4));
  EXPECT_TRUE(after.gap);
  EXPECT_FALSE(before.gap);
  EXPECT_EQ(session.counters().gaps, 1u);
  EXPECT_EQ(session.counters().missed, 4u);
  EXPECT_FALSE(take(session, batch_at(8, 6e-4)).gap);

  Bounding bound(bounding_config({}, test::device()));
  const auto rendered = [&](double dz, double hold_time, double depth) {
    BoundingStep step;
    step.displacement = {0, 0, dz};
    step.hold_time = hold_time;
    step.command.elastic = {0, 0, 2000 * depth};
    return bound.step(step).rendered.elastic.z();
  };
  rendered(0, 1e-3, 0);
  EXPECT_NEAR(rendered(-1e-4, 1e-3, 1e-4), before.command.elastic.z(), 1e-12);
  EXPECT_NEAR(rendered(-5e-4, 5e-3, 6e-4), after.command.elastic.z(), 1e-12);
  EXPECT_TRUE(after.bound.active);  // The bound acted, so the hold time mattered.
}

/// If a hold lasted longer than the sample indices indicate, the client's clock must count.
TEST(Session, LateSampleEarnsLessDampingCredit) {
  const Scene scene = test::room(0.0);
  Session punctual(join_request(), scene), late(join_request(), scene);
  auto batch_at = [](std::uint64_t index, std::int64_t milliseconds) {
    SampleBatch batch = hand_batch(index);
    batch.samples[0].pose.position = {-0.1, 0, -1e-3 * static_cast<double>(index)};
    batch.samples[0].client_time = Nanoseconds(milliseconds * 1'000'000);
    return batch;
  };
  take(punctual, batch_at(1, 1));
  take(late, batch_at(1, 1));
  const double on_time = take(punctual, batch_at(2, 2)).command.elastic.z();
  EXPECT_LT(take(late, batch_at(2, 9)).command.elastic.z(), 0.9 * on_time);
  // A clock that runs backwards must be ignored.
  EXPECT_TRUE(late.take(batch_at(3, -5), kNow).reply.command.finite());
}

TEST(Session, SideSaysWhoBounds) {
  const Scene scene = test::room();
  for (const auto side : {BoundingSide::server, BoundingSide::client, BoundingSide::both}) {
    SessionParameters parameters = test::server_bounds();
    parameters.side = side;
    Session session(join_request(parameters), scene);
    SampleBatch batch = hand_batch(1);
    batch.samples[0].pose.position = {-0.1, 0, -0.004};  // The first sample has no movement yet.
    const Reply reply = take(session, batch);
    if (side == BoundingSide::client) {
      EXPECT_NEAR(reply.command.elastic.z(), 8.0, 1e-9);
      EXPECT_FALSE(reply.bound.active);
    } else {
      EXPECT_EQ(reply.command.elastic.z(), 0.0);
      EXPECT_TRUE(reply.bound.active);
      EXPECT_EQ(reply.bound.ratio, 0.0);
    }
  }
}

/// Over any movement of the hand, the commands must deliver at most the energy that the device
/// dissipates.
TEST(Session, CommandsArePassiveWhateverTheHandDoes) {
  const Scene scene = test::room(0.0);
  for (const std::string_view mode : {"contact_frame", "none"}) {
    SessionParameters parameters = test::server_bounds();
    parameters.mode = mode;
    Session session(join_request(parameters), scene);
    // `port` holds each command from its own sample on. `reported` holds the force that samples
    // report, a sample later. The observer must count `reported`.
    PortEnergy port(test::device().damping, 0, parameters.servo_period), reported = port;
    test::Generator random(17);
    Vec3 position(0, 0, -0.001);
    Command held, held_before;
    for (std::uint64_t n = 1; n <= 20'000; ++n) {
      // The hand mostly moves with the force to extract energy.
      Vec3 step = test::vector(random, 2e-4);
      if (random() % 4 != 0 && held.force().norm() > 0)
        step = held.force().normalized() * test::uniform(random, 0, 3e-4);
      if (position.z() > 0) step.z() = -1e-3;
      position += step;
      SampleBatch batch = hand_batch(n);
      batch.samples[0].pose.position = position;
      batch.samples[0].held = held;
      if (n > 1) {
        port.step(held, step, Vec3::Zero(), parameters.servo_period);
        reported.step(held_before, step, Vec3::Zero(), parameters.servo_period);
      }
      held_before = held;
      held = take(session, batch).command;
    }
    if (mode == "none")
      EXPECT_GT(port.violations(), 100u);  // Without a bound the hand can extract too much energy.
    else
      EXPECT_EQ(port.violations(), 0u);
    EXPECT_NEAR(session.delivered().total(), reported.delivered().total(), 1e-9);
  }
}

TEST(Session, ObserverCountsTheLastKnownForceOverAGap) {
  const Scene scene = test::room();
  Session session(join_request(), scene);
  auto batch_at = [](std::uint64_t index, double z, double force) {
    SampleBatch batch = hand_batch(index);
    batch.samples[0].pose.position = {0, 0, z};
    batch.samples[0].held.elastic = {0, 0, force};
    return batch;
  };
  take(session, batch_at(1, 0.0, 2.0));
  EXPECT_NEAR(take(session, batch_at(2, 0.001, 3.0)).delivered.elastic, 0.002, 1e-15);
  EXPECT_NEAR(take(session, batch_at(9, 0.003, 9.0)).delivered.elastic, 0.002 + 0.006, 1e-15);
}

TEST(Session, DeterministicToTheBit) {
  const Scene scene = test::room();
  SessionParameters parameters = test::server_bounds();
  parameters.velocity_cutoff = 200;
  Session first(join_request(parameters), scene), second(join_request(parameters), scene);
  for (std::uint64_t n = 1; n <= 3000; n += 1 + n % 5 / 4) {
    const Reply a = take(first, hand_batch(n, 2));
    const Reply b = second.take(hand_batch(n, 2), Nanoseconds(static_cast<std::int64_t>(n))).reply;
    expect_same_forces(a, b);
    EXPECT_EQ(a.delivered.total(), b.delivered.total());
  }
}

TEST(Session, RefusedInputKeepsTheContact) {
  const Scene scene = test::room();
  Session troubled(join_request(), scene), untroubled(join_request(), scene);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t n = 1; n <= 500; ++n) {
    for (const Vec3& absurd : {Vec3(nan, 0, 0), Vec3(0, 1e4, 0), Vec3(0, 0, -1e300)}) {
      SampleBatch batch = hand_batch(n, 1);
      batch.samples[0].pose.position = absurd;
      EXPECT_EQ(troubled.take(batch, kNow).drop, DropReason::not_finite);
    }
    SampleBatch none;
    EXPECT_EQ(troubled.take(none, kNow).drop, DropReason::count);
    SampleBatch rising = hand_batch(n + 1, 1);
    std::swap(rising.samples[0].index, rising.samples[1].index);
    if (n > 1) {
      EXPECT_EQ(troubled.take(rising, kNow).drop, DropReason::order);
    }
    expect_same_forces(take(troubled, hand_batch(n)), take(untroubled, hand_batch(n)));
  }
}

TEST(Session, LastIndexThereIs) {
  const Scene scene = test::room();
  Session session(join_request(), scene);
  take(session, hand_batch(1));
  SampleBatch last = hand_batch(2);
  last.samples[0].index = std::numeric_limits<std::uint64_t>::max();
  last.samples[0].client_time = Nanoseconds::min();
  EXPECT_TRUE(take(session, last).command.finite());
  EXPECT_EQ(session.take(hand_batch(3), kNow).drop, DropReason::stale);
}

TEST(SessionParametersAtRunTime, ChangeOfBoundGivesNoStepUp) {
  const Scene scene = test::room(0.0);
  Session session(join_request(), scene);
  SampleBatch batch;
  double depth = 0;
  for (std::uint64_t n = 1; n <= 50; ++n) {
    batch = hand_batch(n);
    batch.samples[0].pose.position = {-0.1, 0, -(depth += 5e-5)};
    take(session, batch);
  }
  const auto hold_still = [&] {
    ++batch.samples[0].index;
    return take(session, batch).command.force().norm();
  };
  const double before = hold_still();
  ASSERT_GT(before, 1.0);

  // A parameter outside of the bound must not change the force.
  SessionParameters parameters = test::server_bounds();
  parameters.hold_time = 0.2;
  parameters.redundancy = 5;
  parameters.packet_interval = 3;
  parameters.batch = 2;
  parameters.position_deadband = 0.1;
  parameters.keep_alive = 0.03;
  session.set_parameters(parameters);
  EXPECT_EQ(hold_still(), before);

  const double delivered = session.delivered().total();
  parameters.operator_damping = 3.0;
  session.set_parameters(parameters);
  EXPECT_EQ(hold_still(), 0.0);  // The new bound starts at zero and gives a resting hand no force.
  EXPECT_EQ(session.delivered().total(), delivered);  // The energy count must continue.
  double last = 0.0;
  for (int n = 0; n < 5; ++n) {
    batch.samples[0].pose.position.z() -= 5e-5;
    const double grown = hold_still();
    EXPECT_GT(grown, last);
    last = grown;
  }
}

TEST(SessionParametersAtRunTime, WrongOnesChangeNothing) {
  const Scene scene = test::room();
  Session session(join_request(), scene);
  SessionParameters parameters = test::server_bounds();
  parameters.servo_period = 2e-3;
  EXPECT_THROW(session.set_parameters(parameters), std::invalid_argument);
  parameters = test::server_bounds();
  parameters.c2 = 1e6;  // above b/T
  parameters.mode = "per_axis";
  EXPECT_THROW(session.set_parameters(parameters), std::invalid_argument);
  parameters = test::server_bounds();
  parameters.redundancy = 99;
  EXPECT_THROW(session.set_parameters(parameters), std::invalid_argument);
  EXPECT_EQ(session.parameters().mode, "contact_frame");
  EXPECT_EQ(session.parameters().redundancy, 3);
}

TEST(Session, ImpossibleRequestsAreRefusedAtOnce) {
  const Scene scene = test::room();
  auto request = join_request();
  request.device.damping = -1;
  EXPECT_THROW(Session(request, scene), std::invalid_argument);
  request = join_request();
  request.parameters.servo_period = 0;
  EXPECT_THROW(Session(request, scene), std::invalid_argument);
}

TEST(Session, StepsDoNotAllocate) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  const Scene scene = test::room();
  Session session(join_request(), scene);
  session.take(hand_batch(1), kNow);
  const std::size_t before = test::allocations();
  std::uint64_t touched = 0;
  for (std::uint64_t n = 2; n <= 10'001; n += 1 + n % 7 / 6) {
    const BatchResult taken = session.take(hand_batch(n, 3), kNow);
    touched += taken.reply.command.force().norm() > 0;
    session.take(hand_batch(n, 3), kNow);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(touched, 1000u);
}

}  // namespace
}  // namespace feltwire::session_test
