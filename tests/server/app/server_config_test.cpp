#include "server/app/server_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/base/json_document.hpp"

namespace feltwire::config_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Config, EveryFieldIsRead) {
  const ServerConfig config = parse_config(R"({
    "scenes": ["a.json", "/abs/b.json"],
    "address": "0.0.0.0", "port": 9000, "silence_timeout": 1.5,
    "max_sessions_per_scene": 3, "profile": "thin", "busy_poll": 50, "slow_down": "hands", "real_time": true, "log_level": "debug",
    "dscp": "af41",
    "state": "state", "certificate": "c.pem", "key": "k.pem", "client_ca": "/abs/ca.pem",
    "tokens": "t.json", "max_sessions_per_client": 5, "join_rate": 0.5, "join_burst": 2,
    "handshake_timeout": 1.5, "idle_timeout": 30, "max_connections": 7,
    "max_connections_per_network": 6, "handshake_rate": 8, "handshake_burst": 9
  })",
                                           "/etc/feltwire/server.json");
  ASSERT_EQ(config.scenes.size(), 2u);
  EXPECT_EQ(config.scenes[0], "/etc/feltwire/a.json");
  EXPECT_EQ(config.scenes[1], "/abs/b.json");
  EXPECT_EQ(config.address, "0.0.0.0");
  EXPECT_EQ(config.port, 9000);
  EXPECT_EQ(config.silence_timeout, 1.5);
  EXPECT_EQ(config.max_sessions_per_scene, 3);
  EXPECT_EQ(config.profile, "thin");
  EXPECT_EQ(config.busy_poll, 50.0);
  EXPECT_EQ(config.slow_down, "hands");
  EXPECT_TRUE(config.real_time);
  EXPECT_EQ(config.log.level, "debug");
  EXPECT_EQ(config.dscp, "af41");
  EXPECT_EQ(config.state, "/etc/feltwire/state");
  EXPECT_EQ(config.certificate, "/etc/feltwire/c.pem");
  EXPECT_EQ(config.key, "/etc/feltwire/k.pem");
  EXPECT_EQ(config.client_ca, "/abs/ca.pem");
  EXPECT_EQ(config.tokens, "/etc/feltwire/t.json");
  EXPECT_EQ(config.max_sessions_per_client, 5);
  EXPECT_EQ(config.join_rate, 0.5);
  EXPECT_EQ(config.join_burst, 2.0);
  EXPECT_EQ(config.connections.handshake_timeout, 1.5);
  EXPECT_EQ(config.connections.idle_timeout, 30.0);
  EXPECT_EQ(config.connections.max, 7);
  EXPECT_EQ(config.connections.max_per_network, 6);
  EXPECT_EQ(config.connections.handshake_rate, 8.0);
  EXPECT_EQ(config.connections.handshake_burst, 9.0);
  EXPECT_NO_THROW(validate(config));
}

TEST(Config, WhatIsLeftOutKeepsItsDefault) {
  const ServerConfig read = parse_config("{}", "x.json"), made;
  EXPECT_TRUE(read.scenes.empty());
  EXPECT_EQ(read.address, made.address);
  EXPECT_EQ(read.port, made.port);
  EXPECT_EQ(read.silence_timeout, made.silence_timeout);
  EXPECT_EQ(read.max_sessions_per_scene, made.max_sessions_per_scene);
  EXPECT_EQ(read.sample_rate_limit, made.sample_rate_limit);
  EXPECT_EQ(read.slow_down, made.slow_down);
  EXPECT_EQ(read.profile, made.profile);
  EXPECT_EQ(read.busy_poll, 0.0);
  EXPECT_FALSE(read.real_time);
  EXPECT_EQ(read.log.level, made.log.level);
  EXPECT_EQ(read.dscp, made.dscp);
  EXPECT_TRUE(read.state.empty() && read.certificate.empty() && read.tokens.empty());
  EXPECT_EQ(read.max_sessions_per_client, made.max_sessions_per_client);
  EXPECT_EQ(read.join_rate, made.join_rate);
  EXPECT_EQ(read.join_burst, made.join_burst);
  EXPECT_EQ(read.connections.handshake_timeout, made.connections.handshake_timeout);
  EXPECT_EQ(read.connections.idle_timeout, made.connections.idle_timeout);
  EXPECT_EQ(read.connections.max, made.connections.max);
  EXPECT_EQ(read.connections.max_per_network, made.connections.max_per_network);
  EXPECT_EQ(read.connections.handshake_rate, made.connections.handshake_rate);
  EXPECT_EQ(read.connections.handshake_burst, made.connections.handshake_burst);
}

TEST(Config, ABusyPollMayBeForEver) {
  const ServerConfig config = parse_config(R"({"scenes": ["a.json"], "busy_poll": -1})", "x.json");
  EXPECT_EQ(config.busy_poll, HUGE_VAL);
  EXPECT_NO_THROW(validate(config));
}

TEST(Config, FaultsNameFileLineAndField) {
  const std::vector<std::pair<const char*, const char*>> faults = {
      {"{\n\"port\": 70000}", "port"},
      {"{\n\"port\": -1}", "port"},
      {"{\n\"silence_timeout\": 0}", "silence_timeout"},
      {"{\n\"max_sessions_per_scene\": 0}", "max_sessions_per_scene"},
      {"{\n\"sample_rate_limit\": 1}", "sample_rate_limit"},
      {"{\n\"slow_down\": \"hands,hands\"}", "slow_down"},
      {"{\n\"profile\": \"moon\"}", "profile"},
      {"{\n\"web_names\": [\"lab.example\", \"https://lab.example\"]}", "web_names"},
      {"{\n\"busy_poll\": -2}", "busy_poll"},
      {"{\n\"busy_poll\": 1e7}", "busy_poll"},
      {"{\n\"log_level\": \"loud\"}", "log_level"},
      {"{\n\"dscp\": \"best\"}", "dscp"},
      {"{\n\"address\": \"localhost:80\"}", "address"},
      {"{\n\"scenes\": [\"\"]}", "scenes"},
      {"{\n\"certificate\": \"c.pem\"}", "certificate"},
      {"{\n\"max_sessions_per_client\": 0}", "max_sessions_per_client"},
      {"{\n\"join_rate\": 0}", "join_rate"},
      {"{\n\"join_burst\": 0.5}", "join_burst"},
      {"{\n\"handshake_timeout\": 0}", "handshake_timeout"},
      {"{\n\"idle_timeout\": 1e9}", "idle_timeout"},
      {"{\n\"max_connections\": 1}", "max_connections"},
      {"{\n\"max_connections_per_network\": -1}", "max_connections_per_network"},
      {"{\n\"handshake_rate\": 0}", "handshake_rate"},
      {"{\n\"handshake_burst\": 0.5}", "handshake_burst"},
      {"{\n\"prot\": 6720}", "prot"},
      {"{\n\"port\": \"many\"}", "port"},
      {"{\n\"port\": }", ""},
  };
  for (const auto& [json, field] : faults) {
    try {
      parse_config(json, "some.json");
      ADD_FAILURE() << json;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), AllOf(StartsWith("some.json:2:"), HasSubstr(field))) << json;
    }
  }
  EXPECT_THROW(load_config("/nonexistent/feltwire.json"), std::invalid_argument);
}

TEST(Config, OptionsAreNamedAsOnTheCommandLine) {
  const std::vector<std::pair<const char*, std::function<void(ServerConfig&)>>> faults = {
      {"--scene", [](auto& c) { c.scenes.clear(); }},
      {"--scene", [](auto& c) { c.scenes.resize(257, "x"); }},
      {"--port", [](auto& c) { c.port = 65535; }},  // This leaves no port for the scene.
      {"--address", [](auto& c) { c.address = "nowhere"; }},
      {"zone", [](auto& c) { c.address = "fe80::1"; }},
      {"--silence-timeout", [](auto& c) { c.silence_timeout = 1e9; }},
      {"--dscp", [](auto& c) { c.dscp = "64"; }},
      {"--web-name", [](auto& c) { c.web_names = {"https://lab.example"}; }},
      {"--web-name", [](auto& c) { c.web_names = {"lab.example/live"}; }},
      {"--web-name", [](auto& c) { c.web_names = {"*.example"}; }},
      {"--web-name", [](auto& c) { c.web_names = {""}; }},
      {"--log-level", [](auto& c) { c.log.level = ""; }},
  };
  for (const auto& [option, spoil] : faults) {
    ServerConfig config;
    config.scenes = {"a.json"};
    config.web_names = {"lab.example", "Lab-PC", "lab.example.", "10.0.0.7", "[fd00::7]"};
    ASSERT_NO_THROW(validate(config));
    spoil(config);
    try {
      validate(config);
      ADD_FAILURE() << option;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(option));
    }
  }
}

}  // namespace
}  // namespace feltwire::config_test
