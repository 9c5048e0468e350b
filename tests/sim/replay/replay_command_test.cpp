// Tests feltwire-lab replay, from the command line to the exit status.

#include "sim/replay/replay_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::replay_command_test {
namespace {

using ::testing::HasSubstr;

struct CommandResult {
  int status = -1;
  std::string text;
};
CommandResult run(std::vector<std::string> words) {
  CLI::App app;
  CommandResult said;
  std::ostringstream out;
  add_replay(app, out, said.status);
  std::ranges::reverse(words);  // CLI11 expects this order.
  words.emplace_back("replay");
  app.parse(words);
  said.text = out.str();
  return said;
}

class ReplayCommand : public ::testing::Test {
 protected:
  ReplayCommand() {
    recorded.join(0x100);
    recorded.run(600);
    file = recorded.finish().string();
  }
  test::RecordedScene recorded{test::repository_scene("plane.json")};
  std::string file;
};

TEST_F(ReplayCommand, EqualIsZero) {
  const CommandResult said = run({file});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.text, HasSubstr("\nbit-equal\n"));
  EXPECT_THAT(said.text, HasSubstr("scene plane: 0.600 s, 1 sessions, "));
}

TEST_F(ReplayCommand, DifferenceIsOneWithItsPlace) {
  test::rewrite(file, [](RecordedEvent& event, std::string&) {
    if (event.number == 50) event.digest ^= 4;
    return true;
  });
  const CommandResult said = run({file, "--json"});
  EXPECT_EQ(said.status, 1);
  const auto json = nlohmann::json::parse(said.text);
  EXPECT_EQ(json["bit_equal"], false);
  EXPECT_EQ(json["difference"]["event"], 50);
  EXPECT_EQ(json["difference"]["hand"], 1);
  EXPECT_GT(json["difference"]["sample"], 40);
  EXPECT_THAT(run({file}).text, HasSubstr(", event 50, hand 1, sample "));
}

TEST_F(ReplayCommand, MissingEventsAreOne) {
  test::rewrite(file, [](RecordedEvent& event, std::string&) { return event.number != 50; });
  const CommandResult said = run({file});
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.text, HasSubstr("not complete: 1 events are missing after event 49"));
}

TEST_F(ReplayCommand, OtherSceneIsTaken) {
  EXPECT_EQ(run({file, "--scene", test::repository_scene("plane.json").string()}).status, 0);
  EXPECT_EQ(run({file, "--scene", test::repository_scene("bunny.json").string()}).status, 1);
}

}  // namespace
}  // namespace feltwire::replay_command_test
