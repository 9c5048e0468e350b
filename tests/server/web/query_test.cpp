// Tests the query of a request.

#include "server/web/query.hpp"

#include <gtest/gtest.h>

namespace feltwire {
namespace {

TEST(Query, TheFirstFieldOfThatName) {
  EXPECT_EQ(query_value("ticket=fw_1", "ticket"), "fw_1");
  EXPECT_EQ(query_value("a=1&ticket=2&ticket=3", "ticket"), "2");
  EXPECT_EQ(query_value("ticket=", "ticket"), "");
  EXPECT_EQ(query_value("a=b=c", "a"), "b=c");
  for (const char* none : {"", "ticket", "tickets=1", "xticket=1", "&&", "=1"})
    EXPECT_EQ(query_value(none, "ticket"), std::nullopt) << none;
}

TEST(Query, Escapes) {
  EXPECT_EQ(query_value("scene=two%20words%2F%c3%A4", "scene"), "two words/\xc3\xa4");
  for (const char* malformed : {"scene=%", "scene=%2", "scene=%2g", "scene=%-1", "scene=a%"})
    EXPECT_EQ(query_value(malformed, "scene"), std::nullopt) << malformed;
}

}  // namespace
}  // namespace feltwire
