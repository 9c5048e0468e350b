// The extremes study must pass methods that keep their guarantee, and detect others.

#include "sim/studies/bound/extremes.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "sim/studies/bound/passivity_claims.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::extremes_test {
namespace {

using test::text_of;
using ::testing::HasSubstr;

const ExtremeRow& row(const std::vector<ExtremeRow>& rows, std::string_view stress,
                      std::string_view method) {
  for (const ExtremeRow& r : rows)
    if (r.stress == stress && r.method == method) return r;
  throw std::out_of_range("no such row");
}

TEST(Extremes, EveryMethodKeepsWhatItPromises) {
  const auto rows = run_extremes(1.0, 5);
  std::set<std::string> stresses;
  for (const ExtremeRow& r : rows) {
    stresses.insert(r.stress);
    EXPECT_TRUE(r.passed()) << r.stress << ' ' << r.method;
    for (const ExtremeOutcome* o : {&r.in_double, &r.in_float}) EXPECT_GE(o->steps, 200u);
    // A bound must render some force, otherwise the test proves nothing. The forces of the other
    // methods soon diverge.
    if (r.promise != Promise::port || r.stress == "damping 0") continue;
    // There the smallest energies of a tank and of an account are zero.
    const bool counts_energy = r.method == "energy_tank" || bounding_method(r.method).shapes;
    if (r.stress == "movements denormal" && counts_energy) continue;
    EXPECT_GT(r.in_double.rendering, 100u) << r.stress << ' ' << r.method;
    EXPECT_GT(r.in_float.rendering, 100u) << r.stress << ' ' << r.method;
  }
  EXPECT_GE(stresses.size(), 30u);
  EXPECT_EQ(rows.size(), stresses.size() * bounding_method_names().size());
  EXPECT_TRUE(all_passed(rows));
}

// The method assumes five percent too much damping. Every stress with hands that can use this error
// must detect it, in double and in float.
TEST(Extremes, FivePercentTooMuchDampingIsFound) {
  const auto rows = run_extremes(1.05, 1);
  EXPECT_FALSE(all_passed(rows));
  EXPECT_THAT(extremes_table(rows), HasSubstr("FAILED"));
  for (const char* stress :
       {"an ordinary hand", "period 1 us", "period 0.1 s", "hand still; force held",
        "movements denormal", "movements 1e-300 to 1e3 m", "forces 1 MN to 1 TN",
        "damping 1e6 N s/m", "damping 1e6; period 1 us", "damping by direction 100:1",
        "1e6 m from the origin", "limit 0.3 N", "fades", "holds up to 50 T", "NaN; Inf; absurd"}) {
    const ExtremeRow& r = row(rows, stress, "contact_frame");
    EXPECT_TRUE(r.in_double.broken) << stress;
    EXPECT_TRUE(r.in_float.broken) << stress;
    // An account renders no force there, or little, since nothing is burned.
    const std::set<std::string_view> little = {"movements denormal", "hand still; force held"};
    EXPECT_TRUE(row(rows, stress, "shaped").in_double.broken || little.contains(stress)) << stress;
  }
}

// per_axis and the coupling store more energy than necessary. Only a larger error is detectable.
TEST(Extremes, FiveTimesTheDampingIsFoundInEveryLawThatCountsOnIt) {
  const auto rows = run_extremes(5.0, 2);
  for (const char* method : {"contact_frame", "energy_tank", "per_axis", "virtual_coupling"}) {
    const ExtremeRow& r = row(rows, "an ordinary hand", method);
    EXPECT_TRUE(r.in_double.broken) << method;
    EXPECT_TRUE(r.in_float.broken) << method;
  }
  EXPECT_TRUE(row(rows, "wall 1e+09 N/m; at 1e6 m", "contact_frame").in_float.broken);
}

TEST(Extremes, AForceWithoutDampingIsFound) {
  for (const bool one_balance : {false, true})
    for (const Promise promised : {Promise::port, Promise::port_by_axis}) {
      PromiseLedger ledger({.promise = promised,
                            .damping = 0.0,
                            .rotational_damping = 0.0,
                            .period = 1e-3,
                            .arithmetic = kArithmetic<double>,
                            .one_balance = one_balance});
      const Vec3 moved(1e-3, 0.0, 0.0);
      Command rendered;
      ledger.rendered(rendered, rendered, moved, Vec3::Zero());
      EXPECT_FALSE(ledger.broken());
      rendered.elastic.x() = 1.0;
      ledger.rendered(rendered, rendered, moved, Vec3::Zero());
      EXPECT_TRUE(ledger.broken()) << one_balance;
    }
}

TEST(Extremes, WhatIsToldMustBeADamping) {
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(run_extremes(bad), std::invalid_argument) << bad;
  EXPECT_THROW(run_extremes(1.0, 0), std::invalid_argument);
}

TEST(Extremes, TheSameBytesEveryTime) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_extremes_test";
  for (const char* turn : {"a", "b"}) {
    const auto rows = run_extremes(1.0, 1);
    write_extremes(directory / turn, rows);
    draw_extremes(directory / turn, rows);
  }
  for (const char* file : {"extremes.csv", "extremes.json", "extremes.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 10000u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  std::filesystem::remove_all(directory);
}

TEST(Extremes, TheCommandFailsWhenARowFails) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_extremes_exit";
  const auto status = [&](const std::string& options) {
    const std::string command = std::string(FELTWIRE_LAB_PROGRAM) + " extremes --out " +
                                directory.string() + " " + options + " > /dev/null 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(status("--hands 1"), 0);
  EXPECT_EQ(status("--hands 1 --assumed-damping 1.05"), 1);
  EXPECT_EQ(status("--hands 0"), 1);
  std::filesystem::remove_all(directory);
}

// A manual example with T = 1 ms, b = 0.5 N s/m, c = 1000 N/m: pressing 1 mm dissipates 0.5 mJ.
// This covers 1 N, from which a hand can extract 0.5 mJ.
TEST(PromiseLedger, PaysForAForceUpToTheLastPartInAMillion) {
  for (const double newton : {1.0 - 1e-6, 1.0, 1.0 + 1e-6}) {
    PromiseLedger ledger({.damping = 0.5});
    ledger.moved({}, Vec3(-1e-3, 0, 0), Vec3::Zero(), 1e-3);
    Command held;
    held.elastic.x() = newton;
    ledger.rendered(held, held, Vec3(-1e-3, 0, 0), Vec3::Zero());
    EXPECT_EQ(ledger.broken(), newton > 1.0) << newton;
    if (newton > 1.0) {
      EXPECT_NEAR(ledger.error(), 2e-6, 1e-8);
    }
  }
}

TEST(PromiseLedger, TogetherTheForcePaysForTheTorqueAndNotTwice) {
  for (const double share : {0.99, 1.01}) {
    PromiseLedger ledger({.damping = 0.5, .rotational_damping = 2e-4, .one_balance = true});
    ledger.moved({}, Vec3(-1e-3, 0, 0), Vec3::Zero(), 1e-3);  // 0.5 mJ burned
    Command held;
    held.elastic.x() = share * std::sqrt(0.5);        // half of it is at stake: f^2 T / (4 b)
    held.torque.x() = share * std::sqrt(0.5 * 4e-4);  // and the other half
    ledger.rendered(held, held, Vec3(-1e-3, 0, 0), Vec3::Zero());
    EXPECT_EQ(ledger.broken(), share > 1.0) << share;
  }
}

TEST(PromiseLedger, AHoldOfTwoPeriodsBurnsHalf) {
  PromiseLedger ledger({.damping = 0.5});
  ledger.moved({}, Vec3(-1e-3, 0, 0), Vec3::Zero(), 2e-3);
  Command held;
  held.elastic.x() = 0.7;  // The energy covers sqrt(1/2) N.
  ledger.rendered(held, held, Vec3(-1e-3, 0, 0), Vec3::Zero());
  EXPECT_FALSE(ledger.broken());
  held.elastic.x() = 0.71;
  ledger.rendered(held, held, Vec3(-1e-3, 0, 0), Vec3::Zero());
  EXPECT_TRUE(ledger.broken());
}

TEST(PromiseLedger, ByAxisNoAxisPaysForAnother) {
  for (const Promise promise : {Promise::port, Promise::port_by_axis}) {
    PromiseLedger ledger({.promise = promise, .damping = 0.5});
    ledger.moved({}, Vec3(-1e-3, 0, 0), Vec3::Zero(), 1e-3);
    Command held;
    held.elastic.y() = 0.5;  // The energy of the x axis is already used.
    ledger.rendered(held, held, Vec3(-1e-3, 0, 0), Vec3::Zero());
    EXPECT_EQ(ledger.broken(), promise == Promise::port_by_axis);
  }
}

}  // namespace
}  // namespace feltwire::extremes_test
