// A process that ends while its handles are open.

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "client/c_api/feltwire.h"
#include "core/recording/mcap_reader.hpp"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"

namespace feltwire::c_api_test {
namespace {

using Json = nlohmann::json;

/// The server would keep a session for an hour if nobody said goodbye.
struct PatientServer : ApiServer {
  static constexpr double kHour = 3600.0;
  PatientServer() : ApiServer(testing::floor_scene(), {}, kHour) {}

  std::size_t sessions() const {
    const fw_admin_options options = admin_options();
    fw_admin* admin = nullptr;
    EXPECT_EQ(fw_admin_open(&options, &admin), FW_OK) << fw_last_error();
    const char* answer = nullptr;
    const char* word = "sessions";
    EXPECT_EQ(fw_admin_request(admin, &word, 1, &answer), FW_OK) << fw_last_error();
    const std::size_t count = answer != nullptr ? Json::parse(answer).size() : 0;
    fw_admin_close(admin);
    return count;
  }
};

/// The threads of the handles must not run while exit handlers free what they use. Such a run ended
/// with a segmentation fault now and then, so it is repeated.
TEST(EndOfProcess, HandlesThatAreLeftOpenEndInOrder) {
  const PatientServer server;
  constexpr int kRuns = 12;
  for (int run = 0; run < kRuns; ++run) {
    const std::string file = (server.folder / ("hand" + std::to_string(run) + ".mcap")).string();
    test::Program program(FELTWIRE_LEFT_OPEN_PROGRAM,
                          {server.address, server.fingerprint, server.token_file, file});
    const test::Outcome outcome = program.finish();
    ASSERT_EQ(outcome.status, 0) << outcome.error;
    std::ifstream in(file, std::ios::binary);
    mcap::Reader reader(in, file);
    while (reader.next()) continue;
    EXPECT_FALSE(reader.cut_at()) << "the recording has its end";
    test::eventually("goodbye", [&] { return server.sessions() == 0; });
  }
}

}  // namespace
}  // namespace feltwire::c_api_test
