// Tests the study's claims on a small grid: the savings and costs of a deadband. No hand may get
// more energy than the device dissipated.

#include "sim/studies/network/deadband_study.hpp"

#include <gtest/gtest.h>

namespace feltwire::deadband_study_test {
namespace {

std::vector<DeadbandTask> short_tasks() {
  std::vector<DeadbandTask> tasks = deadband_tasks();
  for (DeadbandTask& task : tasks) task.duration = 0.8;
  return tasks;
}

TEST(DeadbandStudy, SavesDatagramsAndKeepsTheForce) {
  DeadbandGrid grid;
  grid.fractions = {0.0, 0.1};
  const auto rows = run_deadband(short_tasks(), grid);
  ASSERT_EQ(rows.size(), 4 * std::size(kDeadbandKinds) * 2);
  for (const DeadbandRow& r : rows) {
    EXPECT_EQ(r.violations, 0u) << r.task << r.kind->name;
    if (r.fraction == 0.0) {
      EXPECT_EQ(r.saved, 0.0);
      EXPECT_EQ(r.error_max, 0.0);
      continue;
    }
    EXPECT_EQ(r.saved_up > 0.3, r.kind->position) << r.task << r.kind->name;
    EXPECT_GT(r.saved_down, 0.3) << r.task << r.kind->name;
    // Each deadband allows an error of k in the force.
    EXPECT_LT(r.relative, r.kind->position && r.kind->force ? 0.21 : 0.11)
        << r.task << r.kind->name;
    EXPECT_GT(r.error_max, 0.0) << r.task << r.kind->name;
  }
}

TEST(DeadbandStudy, ARecordingIsItsOwnMovement) {
  Recording recording;
  for (int i = 0; i <= 60; ++i)
    recording.poses.push_back(
        {0.02 * i, {.position = Vec3(1e-3 * i, 0, i % 20 < 10 ? 2e-3 : -2e-3)}});
  auto tasks = deadband_tasks(recording);
  ASSERT_EQ(tasks.size(), 5u);
  DeadbandGrid grid;
  grid.fractions = {0.1};
  const auto rows = run_deadband({tasks.back()}, grid);
  for (const DeadbandRow& r : rows) {
    EXPECT_EQ(r.task, "recording");
    EXPECT_EQ(r.violations, 0u);
    EXPECT_GT(r.saved, 0.2);
  }
}

}  // namespace
}  // namespace feltwire::deadband_study_test
