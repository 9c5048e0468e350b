// Tests the server's JSON output: summary and tokens.

#include "server/access/json_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "server/access/tokens.hpp"
#include "server/app/summary.hpp"
#include "tests/support/failing_allocation.hpp"

namespace feltwire::json_text_test {
namespace {

using Json = nlohmann::ordered_json;

TEST(JsonText, IsReadBackAsItWas) {
  const std::string odd = "a \"room\"\n\\ \xc3\xa4 \x01";
  const std::string written = json_text::object(
      {{"name", json_text::text(odd)},
       {"no \"entries\"", json_text::list({})},
       {"least", json_text::number(std::numeric_limits<std::int64_t>::min())},
       {"list", json_text::list({json_text::number(std::numeric_limits<std::uint64_t>::max()),
                                 json_text::object({{"in", json_text::text("x")}})})}});
  const Json expected = {{"name", odd},
                         {"no \"entries\"", Json::array()},
                         {"least", std::numeric_limits<std::int64_t>::min()},
                         {"list", {std::numeric_limits<std::uint64_t>::max(), {{"in", "x"}}}}};
  EXPECT_EQ(Json::parse(written), expected);
  EXPECT_EQ(written, expected.dump(2));
}

TEST(JsonText, WhatIsNoUtf8IsReplaced) {
  EXPECT_EQ(Json::parse(json_text::text("a\xff")), "a\xef\xbf\xbd");
}

#ifndef FELTWIRE_SANITIZED
/// With a tree of nlohmann::json, a failed allocation would end the program.
TEST(JsonText, EveryAllocationRefusedEndsInAnException) {
  SceneSummary scene;
  scene.scene = "room";
  Tokens tokens(3);
  int refused = 0;
  for (bool happened = true; happened; refused += happened ? 1 : 0) {
    const test::FailingAllocation failing(refused + 1);
    std::thread([&] {
      try {
        summary_json({scene, scene}, {});
        json(tokens);
      } catch (const std::bad_alloc&) {
        // The test expects this exception.
      }
    }).join();
    happened = failing.happened();
  }
  EXPECT_GT(refused, 100);
}
#endif

}  // namespace
}  // namespace feltwire::json_text_test
