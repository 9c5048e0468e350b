// What Prometheus reads of histograms: classes that add up, a sum in seconds, a count.

#include "server/app/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace feltwire {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, AHistogramAddsUp) {
  SceneSummary scene;
  scene.scene = "a \"room\"";
  scene.answers.record(15'000, 3);    // up to 20 us
  scene.answers.record(150'000);      // up to 200 us
  scene.answers.record(900'000'000);  // longer than all
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

}  // namespace
}  // namespace feltwire
