// Tests feltwire-lab link as a program.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/help.hpp"
#include "tests/support/program.hpp"

namespace feltwire::link_program_test {
namespace {

using test::Outcome;
using test::Program;
using ::testing::AllOf;
using testing::Client;
using ::testing::HasSubstr;
using testing::kPatience;
using testing::kStroke;
using testing::Loopback;

class LinkProgram : public Loopback {
 protected:
  std::string server_port() const { return std::to_string(endpoint.endpoint.port); }
  testing::TemporaryFolder folder;
};

TEST_F(LinkProgram, RelaysUntilItIsToldAndThenReports) {
  for (const int ending : {SIGINT, SIGTERM}) {
    const auto file = folder / "link.json";
    Program program(FELTWIRE_LAB_PROGRAM,
                    {"link", "delay=1,loss=5,seed=4", "--listen", "0", "--scenes", "2", "--to",
                     "127.0.0.1:" + server_port(), "--report", file.string()});
    const std::string line = program.line();
    unsigned port = 0, first = 0, last = 0, to = 0;
    ASSERT_EQ(
        std::sscanf(line.c_str(), "relaying: control tcp %u, scenes udp %u to %u, to 127.0.0.1:%u",
                    &port, &first, &last, &to),
        4)
        << line;
    EXPECT_EQ(first, port + 1);
    EXPECT_EQ(last, port + 2);
    EXPECT_EQ(to, endpoint.endpoint.port);
    {
      Client client(test::access(static_cast<std::uint16_t>(port)), kStroke, {}, "floor");
      client.start();
      client.finish();
      EXPECT_EQ(client.result->end, EndReason::device_ended);
      EXPECT_GT(client.servo.statistics().replies.answered, 0u);
    }
    program.signal(ending);
    EXPECT_EQ(program.finish().status, 0);
    const auto report = nlohmann::json::parse(testing::text_of(file));
    EXPECT_EQ(report["link"], "delay=1,loss=5,seed=4");
    ASSERT_EQ(report["clients"].size(), 1u);
    EXPECT_EQ(report["clients"][0]["link"]["seed"], 4);
    EXPECT_GT(report["clients"][0]["link"]["up"]["delivered"], 0);
  }
}

TEST_F(LinkProgram, FaultsAreOneLineAndANonZeroExit) {
  const auto expect_fault = [](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin(), "link");
    const Outcome outcome = Program(FELTWIRE_LAB_PROGRAM, arguments).finish();
    EXPECT_GT(outcome.status, 0);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.error, HasSubstr(part));
  };
  const std::string to = "127.0.0.1:" + server_port();
  expect_fault({"wifi,dely=3", "--to", to}, "'dely'");
  expect_fault({"wifi", "--to", "somewhere"}, "HOST:PORT");
  expect_fault({"wifi", "--to", to, "--listen", server_port()}, "--listen");
  expect_fault({"wifi", "--to", to, "--report", "/proc/nowhere/report.json"},
               "/proc/nowhere/report.json");
  expect_fault({"wifi"}, "--to");
}

TEST(LabProgram, SaysWhatAWordMayHaveMeant) {
  const auto said = [](std::vector<std::string> words) {
    return Program(FELTWIRE_LAB_PROGRAM, std::move(words)).finish().error;
  };
  EXPECT_THAT(said({"tuch"}), HasSubstr("did you mean touch?"));
  EXPECT_THAT(said({"link", "wifi", "--too", "x:1"}), HasSubstr("did you mean --to?"));
}

/// A terminal executes an escape sequence from any source.
TEST(LabProgram, WordsOfTheCommandLineReachNoTerminalUnescaped) {
  const std::string evil = "\x1b]0;owned\x07";
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{evil},
                                             {"--" + evil},
                                             {"touch", "--scene", evil},
                                             {"touch", evil, "--scene", "x"},
                                             {"link", evil, "--to", "x:1"},
                                             {"export", evil, "--csv", "x"},
                                             {"bound", "--period", evil, "--damping", "1"},
                                             {"summary", evil}}) {
    const Outcome outcome = Program(FELTWIRE_LAB_PROGRAM, words).finish();
    EXPECT_NE(outcome.status, 0);
    EXPECT_EQ(outcome.error.find('\x1b'), std::string::npos) << words.front();
    EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos) << words.front();
    // The error for an unknown subcommand does not quote the word.
    if (words.size() > 1) {
      EXPECT_THAT(outcome.error, HasSubstr("\\x1b]0;owned")) << words.front();
    }
  }
}

TEST(LabProgram, ANumberWithItsUnitIsNamed) {
  const auto error =
      Program(FELTWIRE_LAB_PROGRAM, {"bound", "--period", "1ms", "--damping", "1"}).finish().error;
  EXPECT_THAT(error, HasSubstr("write the number without unit, in s: 0.001"));
}

TEST(LabProgram, ExamplesNameFilesThatExist) {
  EXPECT_GE(test::expect_files_of_examples(FELTWIRE_LAB_PROGRAM, {"touch"}), 1);
  test::expect_files_of_examples(FELTWIRE_LAB_PROGRAM, {"bound"});
  test::expect_files_of_examples(FELTWIRE_LAB_PROGRAM, {"link"});
}

}  // namespace
}  // namespace feltwire::link_program_test
