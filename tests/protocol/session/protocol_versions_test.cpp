#include "protocol/session/protocol_versions.hpp"

#include <gtest/gtest.h>

namespace feltwire::protocol_versions_test {
namespace {

TEST(ProtocolVersions, TwoProgramsSpeakTheNewestOfBoth) {
  const auto common = [](const ProtocolVersions& one, const ProtocolVersions& other) {
    const auto version = common_version(one, other);
    EXPECT_EQ(version, common_version(other, one));
    return version;
  };
  EXPECT_EQ(common({.newest = 2, .oldest = 2}, {.newest = 2, .oldest = 2}), 2);
  EXPECT_EQ(common({.newest = 5, .oldest = 2}, {.newest = 3, .oldest = 1}), 3);
  EXPECT_EQ(common({.newest = 3, .oldest = 3}, {.newest = 9, .oldest = 1}), 3);
  EXPECT_EQ(common({.newest = 1, .oldest = 1}, {.newest = 2, .oldest = 2}), std::nullopt);
  EXPECT_EQ(common({.newest = 9, .oldest = 4}, {.newest = 3, .oldest = 1}), std::nullopt);
}

TEST(ProtocolVersions, ARefusalSaysWhichSideIsTheOlder) {
  const ProtocolVersions server{.newest = 3, .oldest = 2};
  EXPECT_EQ(refused_client({.newest = 1, .oldest = 1}, server),
            "this client speaks version 1 of the feltwire protocol, this server versions 2 to 3; "
            "install a newer client");
  EXPECT_EQ(
      refused_client({.newest = 5, .oldest = 4}, server),
      "this client speaks versions 4 to 5 of the feltwire protocol, this server versions 2 to "
      "3; install a newer server");
}

}  // namespace
}  // namespace feltwire::protocol_versions_test
