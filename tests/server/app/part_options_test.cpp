#include "server/app/part_options.hpp"

#include <gtest/gtest.h>

namespace feltwire::part_options_test {
namespace {

TEST(PartOptions, AClientMayConnectTwiceForEachOfItsSessions) {
  ServerConfig config;
  config.connections = {.handshake_timeout = 1.5,
                        .idle_timeout = 0.25,
                        .max = 7,
                        .max_per_network = 6,
                        .handshake_rate = 8.0,
                        .handshake_burst = 9.0};
  ControlOptions options = control_options(config);
  EXPECT_EQ(options.handshake_timeout, std::chrono::milliseconds(1500));
  EXPECT_EQ(options.idle_timeout, std::chrono::milliseconds(250));
  EXPECT_EQ(options.max_connections, 7u);
  EXPECT_EQ(options.max_connections_per_network, 6u);
  EXPECT_EQ(options.handshake_rate, 8.0);
  EXPECT_EQ(options.handshake_burst, 9.0);
  EXPECT_EQ(options.max_connections_per_client, ControlOptions{}.max_connections_per_client);
  config.max_sessions_per_client = 100;
  options = control_options(config);
  EXPECT_EQ(options.max_connections_per_client, 200u);
}

TEST(PartOptions, AHostGetsTheLineOfItsProfile) {
  ServerConfig config;
  EXPECT_EQ(host_options(config).line, nullptr);
  config.profile = "wan";
  config.silence_timeout = 0.5;
  config.busy_poll = 20.0;
  const SceneHostOptions options = host_options(config);
  ASSERT_NE(options.line, nullptr);
  EXPECT_EQ(options.line->name, "wan");
  EXPECT_EQ(options.silence_timeout, std::chrono::milliseconds(500));
  EXPECT_EQ(options.busy_poll, std::chrono::microseconds(20));
}

TEST(PartOptions, NothingIsRecordedUnlessAFileOrAFolderIsNamed) {
  ServerConfig config;
  EXPECT_FALSE(recorder_options(config).any());
  config.recording.flight_folder = "flights";
  EXPECT_TRUE(recorder_options(config).any());
}

}  // namespace
}  // namespace feltwire::part_options_test
