// Code, schema, documents and container files must state equal default ports.

#include "protocol/net/ports.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "core/base/json_document.hpp"
#include "server/app/server_config.hpp"

namespace feltwire::ports_test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

const fs::path kRoot = FELTWIRE_SOURCE_DIR;
constexpr int kScenes = 16;  // number of scenes for which the relay opens ports
constexpr int kFirstDds = 7400, kFirstEphemeral = 32768;
constexpr int kFirstUnassigned = 6717, kLastUnassigned = 6766;  // the IANA block of our port

std::string file(const char* name) { return read_text(kRoot / name); }

/// Returns the numbers in the first group of a pattern's matches.
std::set<int> found(const std::string& text, const char* pattern) {
  std::set<int> numbers;
  const std::regex regex(pattern);
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at)
    numbers.insert(std::stoi((*at)[1]));
  return numbers;
}

TEST(Ports, AreNobodyElses) {
  EXPECT_GE(int{kDefaultPort}, kFirstUnassigned);
  EXPECT_LT(kDefaultPort + kScenes,
            int{kDefaultRelayPort});  // a relay beside a server of 16 scenes
  EXPECT_LE(kDefaultRelayPort + kScenes, kLastUnassigned);
  EXPECT_LT(kLastUnassigned, kFirstDds);
  EXPECT_LT(kLastUnassigned, kFirstEphemeral);
}

TEST(Ports, TheSchemaHasTheSame) {
  EXPECT_EQ(parse_config("{}", "server.json").port, int{kDefaultPort});
  EXPECT_EQ(ServerConfig{}.port, int{kDefaultPort});
}

/// Each port in a command line or address of the documents must be a default port.
TEST(Ports, DocumentsShowTheSame) {
  const std::set<int> ours = {kDefaultPort, kDefaultRelayPort, kExamplePagePort,
                              kExampleMetricsPort};
  std::vector<fs::path> pages = {kRoot / "README.md", kRoot / "protocol/PROTOCOL.md"};
  for (const auto& entry : fs::directory_iterator(kRoot / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  std::size_t seen = 0;
  for (const fs::path& page : pages) {
    for (const int port : found(read_text(page), R"((?:localhost|127\.0\.0\.1|\[::1\]):(\d+))")) {
      EXPECT_THAT(ours, Contains(port)) << page;
      ++seen;
    }
  }
  EXPECT_GE(seen, 4u);
  const std::string number = std::to_string(kDefaultPort);
  EXPECT_THAT(file("docs/server.md"), HasSubstr("| `--port N` | `port` | " + number + " |"));
  EXPECT_THAT(file("protocol/PROTOCOL.md"), HasSubstr("N (" + number + " unless"));
  EXPECT_THAT(file("docs/link.md"),
              HasSubstr("tcp " + std::to_string(kDefaultRelayPort) + " and udp " +
                        std::to_string(kDefaultRelayPort + 1) + " to " +
                        std::to_string(kDefaultRelayPort + kScenes)));
}

TEST(Ports, ContainersOpenTheSame) {
  EXPECT_THAT(file("docker/Dockerfile"),
              HasSubstr("EXPOSE " + std::to_string(kDefaultPort) + "/tcp " +
                        std::to_string(kDefaultPort + 1) + "/udp\n"));
  const std::set<int> one = {kDefaultPort};
  EXPECT_EQ(found(file("docker/server.json"), R"RE("port": (\d+))RE"), one);
  EXPECT_EQ(found(file("docker/compose.yml"), R"((?:server|link):(\d+))"), one);
  EXPECT_EQ(found(file("docs/docker.md"), R"(-p (\d+):\d+ )"), one);
  EXPECT_EQ(found(file("tests/docker/composition.py"), R"(CONTROL_PORT = (\d+))"), one);
}

}  // namespace
}  // namespace feltwire::ports_test
