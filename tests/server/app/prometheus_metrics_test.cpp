// Tests histograms for Prometheus: cumulative buckets, a sum in seconds, a count.

#include "server/app/prometheus_metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/control/control_service.hpp"
#include "server/scene/scene_counters.hpp"

namespace feltwire {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, AHistogramAddsUp) {
  SceneSummary scene;
  scene.scene = "a \"room\"";
  scene.answers.record(15'000, 3);    // bucket up to 20 us
  scene.answers.record(150'000);      // bucket up to 200 us
  scene.answers.record(900'000'000);  // above the last bucket
  scene.counters.world_late.record(500);
  const std::string text = metrics_text({scene}, {}, {});
  const std::string label = "{scene=\"a \\\"room\\\"\"";
  const auto bucket = [&](const std::string& limit, int count) {
    return "feltwire_answer_seconds_bucket" + label + ",le=\"" + limit + "\"} " +
           std::to_string(count) + "\n";
  };
  EXPECT_THAT(text, HasSubstr("# TYPE feltwire_answer_seconds histogram\n" + bucket("1e-05", 0) +
                              bucket("2e-05", 3)));
  EXPECT_THAT(text, HasSubstr(bucket("1e-04", 3) + bucket("2e-04", 4)));
  EXPECT_THAT(
      text, HasSubstr(bucket("0.2", 4) + bucket("+Inf", 5) + "feltwire_answer_seconds_sum" + label +
                      "} 0.900195\n" + "feltwire_answer_seconds_count" + label + "} 5\n"));
  EXPECT_THAT(text, HasSubstr("feltwire_world_late_seconds_sum" + label + "} 5e-07\n"));
}

TEST(Metrics, ClientsTimesAreHistogramsWithoutASum) {
  SceneSummary scene;
  scene.scene = "room";
  scene.counters.client_wakeups = {990, 5, 0, 0, 0, 0, 3, 2};
  const std::string text = metrics_text({scene}, {}, {});
  const std::string name = "feltwire_client_wakeup_late_seconds", label = "{scene=\"room\"";
  EXPECT_THAT(
      text, HasSubstr("# TYPE " + name + " histogram\n" + name + "_bucket" + label +
                      ",le=\"2e-05\"} 990\n" + name + "_bucket" + label + ",le=\"5e-05\"} 995\n"));
  EXPECT_THAT(
      text, HasSubstr(name + "_bucket" + label + ",le=\"0.01\"} 998\n" + name + "_bucket" + label +
                      ",le=\"+Inf\"} 1000\n" + name + "_count" + label + "} 1000\n"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr(name + "_sum")));
}

/// Each counter has a distinct value. Each value in the text therefore belongs to a single counter.
TEST(Metrics, HaveEachCounterOfTheSummary) {
  SceneSummary scene;
  scene.scene = "room";
  std::uint64_t next = 1000;
  SceneCounters& c = scene.counters;
  for (std::uint64_t* counter : {&c.sessions_served,
                                 &c.left,
                                 &c.silent,
                                 &c.flooded,
                                 &c.forged,
                                 &c.evicted,
                                 &c.disturbing,
                                 &c.failed,
                                 &c.datagrams,
                                 &c.late_goodbyes,
                                 &c.samples.samples,
                                 &c.samples.replies,
                                 &c.samples.withheld,
                                 &c.samples.gaps,
                                 &c.samples.missed,
                                 &c.samples.duplicates,
                                 &c.samples.late_ticks,
                                 &c.shed,
                                 &c.slowed,
                                 &scene.unsent})
    *counter = ++next;
  ControlSummary control;
  for (std::uint64_t* counter : {&control.connections.accepted, &control.connections.too_often,
                                 &control.connections.crowded_out, &control.connections.failed,
                                 &control.connections.too_slow, &control.requests.unauthenticated,
                                 &control.requests.forbidden, &control.requests.too_many})
    *counter = ++next;
  const std::string text = metrics_text({scene}, control, {});
  auto all = named_counters(scene.counters);
  const auto of_control = named_counters(control.connections, control.requests);
  all.insert(all.end(), of_control.begin(), of_control.end());
  all.emplace_back("unsent", scene.unsent);
  for (const auto& [name, value] : all) {
    EXPECT_GT(value, 1000u) << name << " is new: give it a value above";
    EXPECT_THAT(text, HasSubstr(" " + std::to_string(value) + "\n")) << name;
  }
}

}  // namespace
}  // namespace feltwire
