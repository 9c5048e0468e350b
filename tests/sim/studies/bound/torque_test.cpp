#include "sim/studies/bound/torque.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "sim/studies/bound/torque_figures.hpp"

namespace feltwire::torque_test {
namespace {

/// The criterion in six degrees of freedom: complete sessions of a tool with a body, with every
/// task and hand, over a link with delay, jitter, loss and reordering.
TEST(Torque, NoSessionGivesAnyHandEnergyInSixDegreesOfFreedom) {
  std::vector<TorqueSession> sessions = torque_sessions();
  std::erase_if(sessions,
                [](const TorqueSession& s) { return s.link.find("loss") == std::string::npos; });
  for (TorqueSession& s : sessions) s.duration = 2.0;
  ASSERT_EQ(sessions.size(), 6 * 4 * kEightHands.size());
  run_sessions(sessions);
  std::size_t felt = 0;
  for (const TorqueSession& s : sessions) {
    EXPECT_EQ(s.violations, 0u) << s.task << ' ' << s.mode << ' ' << s.hand.name;
    EXPECT_LE(s.energy_made, 1e-12) << s.task << ' ' << s.mode << ' ' << s.hand.name;
    EXPECT_LE(s.energy_made_true, 1e-6) << s.task << ' ' << s.mode << ' ' << s.hand.name;
    felt += s.torque_rms > 1e-4 ? 1 : 0;
  }
  EXPECT_GT(felt, sessions.size() / 2) << "sessions in which a torque is felt";
}

/// If the client has body and solids, a delay must have no effect. Planes describe a peg in a ring
/// and a bar on an edge badly. These two tasks must give the torque of a session without delay.
TEST(Torque, OverADelayAWholeBodyIsFeltAsWithoutOne) {
  for (const char* task : {"peg", "roll"}) {
    std::vector<TorqueSession> sessions;
    for (const bool whole : {false, true})
      for (const char* link : {"delay=0", "delay=25,jitter=5,order=free,loss=5,seed=7"})
        sessions.push_back({.task = task,
                            .mode = std::string(kSessionMethod),
                            .link = link,
                            .local_model = true,
                            .whole = whole});
    run_sessions(sessions);
    const double planes_late = sessions[1].torque_error, at_once = sessions[2].torque_error,
                 late = sessions[3].torque_error;
    EXPECT_LT(late, 1.3 * at_once) << task;
    EXPECT_LT(3.0 * late, planes_late) << task;
  }
}

/// Without a bound the criterion fails. This shows that the test above can fail.
TEST(Torque, WithoutABoundTheSamePortMakesEnergy) {
  std::vector<TorqueSession> sessions;
  for (const NamedHand& hand : kEightHands)
    sessions.push_back({.task = "rock",
                        .mode = std::string(kUnbounded),
                        .link = "delay=25,jitter=5,order=free,loss=5,seed=7",
                        .hand = hand,
                        .duration = 2.0});
  run_sessions(sessions);
  EXPECT_GT(std::ranges::max(sessions, {}, &TorqueSession::energy_made).energy_made, 1e-3);
  EXPECT_FALSE(ports_hold({}, sessions));
}

std::vector<TorqueRow> rows_of(const std::string& task, double delay) {
  auto cases = torque_cases();
  std::erase_if(cases, [&](const TorqueCase& c) {
    return c.task != task || c.delay != delay || c.stiffness != 64.0;
  });
  return run_torque(cases);
}

TEST(Torque, OnlyLawsWithoutAPromiseMakeEnergyOnAJointsStop) {
  for (const char* task : {"cone", "cone_friction"})
    for (const double delay : {0.0, 0.02}) {
      const auto rows = rows_of(task, delay);
      ASSERT_EQ(rows.size(), (delay == 0.0 ? 8 : 6) * kEightHands.size());
      EXPECT_TRUE(ports_hold(rows, {})) << task << ' ' << delay;
      const auto unbounded = [](const TorqueRow& row) {
        return row.made.law == kUnbounded && row.energy.measured > 1e-4;
      };
      EXPECT_GT(std::ranges::count_if(rows, unbounded), 4) << task << ' ' << delay;
      for (const TorqueRow& row : rows)
        if (row.made.ports == Ports::two) {
          EXPECT_LE(row.energy.torque, 1e-12) << row.made.law;
          EXPECT_LE(row.energy.force, 1e-12) << row.made.law;
        }
    }
}

double most_at_motor(const std::vector<TorqueRow>& rows) {
  double most = 0.0;
  for (const TorqueRow& row : rows) most = std::max(most, row.energy.real);
  return most;
}

/// On a plant with a motor lag, the true motor is judged. If the account knows the lag, it makes no
/// energy. Without a bound it does.
TEST(Torque, OnAPlantTheTrueMotorMakesNothingIfItsLagIsTold) {
  Plant plant;
  plant.amplifier.lag = 0.3e-3;
  auto cases = torque_cases(plant, true);
  std::erase_if(cases, [](const TorqueCase& c) {
    return c.task != "cone" || c.stiffness != 64.0 || c.ports == Ports::two ||
           (!c.account && c.law != kUnbounded);
  });
  ASSERT_EQ(cases.size(), 3 * kEightHands.size());
  auto bounded = run_torque(cases);
  const auto free = [](const TorqueRow& row) { return !row.made.account; };
  std::vector<TorqueRow> unbounded;
  std::ranges::copy_if(bounded, std::back_inserter(unbounded), free);
  std::erase_if(bounded, free);
  EXPECT_LE(most_at_motor(bounded), 1e-9);
  EXPECT_TRUE(ports_hold(bounded, {}));
  EXPECT_GT(most_at_motor(unbounded), 1e-4);
  for (TorqueRow& row : unbounded) row.made.account = true;
  EXPECT_FALSE(ports_hold(unbounded, {}));
}

TEST(Torque, TheSameCaseGivesTheSameBits) {
  const TorqueCase c{.task = "rock", .law = "credited", .account = true, .delay = 0.02};
  const auto rows = run_torque({c, c});
  EXPECT_EQ(rows[0].oscillation, rows[1].oscillation);
  EXPECT_EQ(rows[0].torque_share, rows[1].torque_share);
  EXPECT_EQ(rows[0].energy.real, rows[1].energy.real);
  EXPECT_GT(rows[0].torque_share, 0.0);
}

TEST(Torque, RefusesATaskThatIsNotThere) {
  EXPECT_THAT([] { run_torque({{.task = "juggle"}}); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("juggle")));
}

/// The paper's figures 5 and 6 for torque: the per-axis bound changes the direction of the torque,
/// and Eq. (3) of docs/bounding.md corrects it.
TEST(TorqueFigures, ProjectionGivesTheTorqueItsDirectionBack) {
  const TorqueFigure bare = run_torque_figure(kUnbounded);
  const TorqueFigure before = run_torque_figure("per_axis");
  const TorqueFigure after = run_torque_figure("per_axis_projected");
  const TorqueFigure frame = run_torque_figure("contact_frame");
  EXPECT_GT(before.direction_error.mean * kDegrees, 5.0);
  for (const TorqueFigure* straight : {&bare, &after, &frame})
    EXPECT_LT(straight->direction_error.max * kDegrees, 1e-3) << straight->mode;
  EXPECT_NEAR(bare.torque_share, 1.0, 1e-9);
  EXPECT_GT(after.torque_share, 0.0);
  EXPECT_LE(frame.energy_made, 1e-12);
}

}  // namespace
}  // namespace feltwire::torque_test
