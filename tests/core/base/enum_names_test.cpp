#include "core/base/enum_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/client/temporary_folder.hpp"

namespace feltwire::enum_names_test {
namespace {

using testing::error_of;

enum class Colour { red, green, blue };
constexpr std::array<std::string_view, 3> kColours = {"red", "green", "blue"};

struct Line {
  std::string_view name;
  double rate;
};
constexpr std::array<Line, 2> kLines = {{{"lan", 1000.0}, {"wan", 100.0}}};

TEST(Choice, EveryValueIsFoundByItsName) {
  for (const Colour colour : {Colour::red, Colour::green, Colour::blue})
    EXPECT_EQ(enum_from_name<Colour>("colour", enum_name(kColours, colour), kColours), colour);
  EXPECT_EQ(get_named("line", "wan", kLines, &Line::name).rate, 100.0);
  static_assert(enum_name(kColours, Colour::blue) == "blue");
}

TEST(Choice, AnErrorListsTheChoices) {
  EXPECT_EQ(
      error_of<std::invalid_argument>([] { enum_from_name<Colour>("colour", "pink", kColours); }),
      "unknown colour 'pink'; choose one of: red green blue");
  EXPECT_EQ(error_of<std::invalid_argument>([] { get_named("line", "", kLines, &Line::name); }),
            "unknown line ''; choose one of: lan wan");
  EXPECT_EQ(joined_names(kLines, "|", &Line::name), "lan|wan");
}

/// A name must match completely, including its case.
TEST(Choice, WhatIsNearlyANameIsNone) {
  for (const std::string_view given : {"", "re", "reds", " red", "Red", "red green"})
    EXPECT_EQ(find_named(kColours, given), nullptr) << given;
}

/// A value from a datagram may have no name.
TEST(Choice, AValueWithoutANameIsUnknown) {
  EXPECT_EQ(enum_name(kColours, static_cast<Colour>(3)), "unknown");
  EXPECT_EQ(enum_name(kColours, static_cast<Colour>(-1)), "unknown");
}

}  // namespace
}  // namespace feltwire::enum_names_test
