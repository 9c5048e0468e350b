// Tests the registry of bounding methods, and methods behind one type.

#include "core/bounding/method.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "core/bounding/bounding.hpp"
#include "tests/core/support.hpp"

namespace feltwire::method_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Renders half of each command, stores the held command and counts the steps.
struct Half {
  int steps = 0;
  Command held;
  Command step(const BoundingStep& s) noexcept {
    ++steps;
    return held = 0.5 * s.command;
  }
  void set_held(const Command& now) noexcept { held = now; }
  BasicProbe<double> probe(const Vec3&, const Vec3&) const noexcept {
    return {Vec3(steps, held.elastic.x(), 0), Vec3::Zero()};
  }
};

BoundingMethod half() {
  return {.name = "half",
          .summary = "half of it",
          .make = [](const BoundingConfig&) -> BoundingLaw { return Half{}; }};
}

std::string refusal(const BoundingMethod& method) {
  try {
    add_bounding_method(method);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "added";
}

BoundingStep pressing(double newton) {
  BoundingStep s;
  s.hold_time = 1e-3;
  s.command.elastic.x() = newton;
  return s;
}

TEST(BoundingMethods, OwnMethodsAreEachFoundByNameWithSomethingToSay) {
  std::set<std::string_view> summaries;
  for (const BoundingMethod* method : bounding_methods()) {
    EXPECT_EQ(&bounding_method(method->name), method);
    EXPECT_LE(method->name.size(), kLongestMethodName);
    EXPECT_FALSE(method->summary.empty());
    EXPECT_EQ(method->summary.find('\n'), std::string_view::npos);
    summaries.insert(method->summary);
    EXPECT_EQ(Bounding(test::config(method->name)).config().mode, method->name);
  }
  EXPECT_EQ(summaries.size(), bounding_methods().size());
  EXPECT_EQ(BoundingConfig{}.mode, kDefaultMethod);
  EXPECT_EQ(bounding_method(kUnbounded).promise, Promise::none);
}

TEST(BoundingMethods, HelpNamesThoseForProductsFirst) {
  const std::string choices = bounding_method_choices();
  EXPECT_THAT(choices,
              HasSubstr("none|total_energy|per_axis|per_axis_projected|contact_frame|shaped; "
                        "for research: midpoint|credited|virtual_coupling|"));
  const std::string lines = bounding_method_summaries();
  EXPECT_EQ(static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')),
            bounding_methods().size());
  EXPECT_LT(lines.find("contact_frame"), lines.find("(research)"));
}

/// A registry entry declares whether its method moves the position at which the scene is evaluated.
/// The method must agree.
TEST(BoundingMethods, OnlyThoseThatSaySoMoveTheProbe) {
  for (const BoundingMethod* method : bounding_methods()) {
    if (method->name == "half") continue;
    Bounding bounding(test::config(method->name));
    test::Random random(3);
    bool moved = false;
    for (int n = 0; n < 1000; ++n) {
      BoundingStep s = pressing(random.uniform(0.0, 5.0));
      s.displacement = random.vector(-5, -3);
      bounding.step(s);
      moved = moved || !bounding.probe(s.displacement, s.rotation).offset.isZero(0);
    }
    EXPECT_EQ(moved, method->moves_probe) << method->name;
    EXPECT_EQ(bounding.takes_endowment(), method->name == "contact_frame") << method->name;
  }
}

TEST(BoundingMethods, AnAddedOneIsUsedByItsName) {
  ASSERT_EQ(refusal(half()), "added");
  BoundingConfig config = test::config("half");
  config.max_force = 3.0;
  Bounding bounding(config);
  EXPECT_EQ(bounding.step(pressing(4.0)).rendered.elastic.x(), 2.0);
  EXPECT_TRUE(bounding.step(pressing(4.0)).active);
  // The method must get the force that the limit and the caller hold instead of its own.
  EXPECT_EQ(bounding.step(pressing(8.0)).rendered.elastic.x(), 3.0);
  EXPECT_EQ(bounding.probe({}, {}).offset, Vec3(3, 3, 0));
  bounding.set_held({Vec3(1, 0, 0), Vec3::Zero(), Vec3::Zero()});
  EXPECT_EQ(bounding.probe({}, {}).offset, Vec3(3, 1, 0));
  EXPECT_FALSE(bounding.takes_endowment());
  // A command that is not a number must give no force.
  EXPECT_EQ(bounding.step(pressing(kNan)).rendered.force(), Vec3::Zero());

  EXPECT_THAT(refusal(half()), AllOf(HasSubstr("'half'"), HasSubstr("take another")));
  const auto names = bounding_method_names();
  EXPECT_EQ(std::count(names.begin(), names.end(), "half"), 1);
}

TEST(BoundingMethods, ACopyHasAMemoryOfItsOwn) {
  const BoundingMethod entry = half();
  Bounding one(entry, test::config("none"));  // An entry outside the registry works too.
  EXPECT_EQ(one.config().mode, "half");
  one.step(pressing(4.0));
  Bounding other = one;
  other.step(pressing(6.0));
  EXPECT_EQ(one.probe({}, {}).offset, Vec3(1, 2, 0));
  EXPECT_EQ(other.probe({}, {}).offset, Vec3(2, 3, 0));
  one = other;
  EXPECT_EQ(one.probe({}, {}).offset, Vec3(2, 3, 0));
  one = Bounding(test::config("none"));
  EXPECT_EQ(one.step(pressing(4.0)).rendered.elastic.x(), 4.0);
  EXPECT_EQ(one.probe({}, {}).offset, Vec3::Zero());
}

TEST(BoundingMethods, WhatIsNoEntryIsRefused) {
  for (const char* name : {"", "Half", "my-bound", "my bound", "caf\xc3\xa9"}) {
    BoundingMethod bad = half();
    bad.name = name;
    EXPECT_THAT(refusal(bad), HasSubstr("a to z")) << name;
  }
  BoundingMethod named = half();
  const std::string longest(kLongestMethodName, 'm'), longer(kLongestMethodName + 1, 'm');
  named.name = longer;
  EXPECT_THAT(refusal(named), HasSubstr("64"));
  BoundingMethod lawless = half();
  lawless.name = "lawless";
  lawless.make = nullptr;
  EXPECT_THAT(refusal(lawless), HasSubstr("has no law"));
  BoundingMethod taken = half();
  taken.name = "per_axis";
  EXPECT_THAT(refusal(taken), HasSubstr("there is one"));
}

TEST(BoundingMethods, APromiseEndsWithAFaultThatItDoesNotOutlast) {
  const auto of = [](const char* name, const Faults& faults) {
    return promise(bounding_method(name), faults);
  };
  constexpr Faults kOverlong{.overlong_holds = true}, kLess{.reductions = true},
      kUnknown{.unknown_inputs = true};
  for (const Faults& faults : {Faults{}, kOverlong, kLess, kUnknown, kAllFaults}) {
    EXPECT_EQ(of("contact_frame", faults), Promise::port);
    EXPECT_EQ(of("energy_tank", faults), Promise::port);
    EXPECT_EQ(of("none", faults), Promise::none);
  }
  EXPECT_EQ(of("per_axis", kLess), Promise::port_by_axis);
  EXPECT_EQ(of("per_axis", kOverlong), Promise::none);
  EXPECT_EQ(of("passivity_control", kOverlong), Promise::own_sum_by_axis);
  EXPECT_EQ(of("passivity_control", kLess), Promise::none);
  for (const Faults& faults : {kOverlong, kLess, kUnknown})
    EXPECT_EQ(of("virtual_coupling", faults), Promise::none);
}

}  // namespace
}  // namespace feltwire::method_test
