#include "client/emulated_link/link_model.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <set>
#include <sstream>

namespace feltwire::link_model_test {
namespace {

using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Le;

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
constexpr std::size_t kSize = 200;  // [bytes] of payload

/// Returns the fates of `count` datagrams, one per period.
std::vector<LinkFate> fates(const LinkOptions& options, std::size_t count, std::uint64_t key = 1,
                            Nanoseconds period = kPeriod) {
  LinkModel model(options, key);
  std::vector<LinkFate> all;
  for (std::size_t i = 0; i < count; ++i)
    all.push_back(model.next(kSize, static_cast<std::int64_t>(i) * period));
  return all;
}

/// Returns the delays [s] of the datagrams that arrived. Datagram i entered at i periods.
std::vector<double> delays(const std::vector<LinkFate>& all) {
  std::vector<double> seconds;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].copies > 0)
      seconds.push_back(1e-9 *
                        static_cast<double>(
                            (all[i].arrivals[0] - static_cast<std::int64_t>(i) * kPeriod).count()));
  return seconds;
}

bool lost(const LinkFate& fate) { return fate.copies == 0; }

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
double deviation(const std::vector<double>& values) {
  const double m = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - m) * (v - m);
  return std::sqrt(sum / static_cast<double>(values.size()));
}
double share_below(const std::vector<double>& values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; });
  return static_cast<double>(below) / static_cast<double>(values.size());
}

/// Matches a measured share within four standard errors of p, for n independent values.
auto share(double p, double n) {
  const double four = 4.0 * std::sqrt(p * (1.0 - p) / n);
  return AllOf(Ge(p - four), Le(p + four));
}

// An independent program computed these numbers from the specification.
TEST(LinkModel, TheSameSeedGivesTheseFatesForEver) {
  LinkOptions options;
  options.delay = 25e-3;
  options.jitter = 5e-3;
  options.keep_order = false;
  options.loss = 0.1;
  options.reorder = options.duplicate = 0.3;
  std::vector<std::int64_t> arrivals;  // [ns] arrival of each copy; -1: lost
  for (const LinkFate& fate : fates(options, 14, link_key(3, 0, LinkDirection::up))) {
    arrivals.push_back(lost(fate) ? -1 : fate.arrivals[0].count());
    if (fate.copies == 2) arrivals.push_back(fate.arrivals[1].count());
  }
  EXPECT_THAT(arrivals,
              ::testing::ElementsAre(21579402, 29738483, 25069325, -1, -1, 41749665, 29703684,
                                     37001592, 30111857, 25040509, 32241186, 25443429, 38228221,
                                     36485177, 33819131, 42471716, 44181971, 47161701));
}

TEST(LinkModel, NothingAskedForNothingDone) {
  for (const LinkFate& fate : fates({}, 1000)) EXPECT_EQ(fate.copies, 1);
  EXPECT_THAT(delays(fates({}, 1000)), ::testing::Each(0.0));
}

TEST(LinkModel, OneSettingLeavesWhatTheOthersDo) {
  LinkOptions plain;
  plain.loss = 0.2;
  plain.delay = 10e-3;
  LinkOptions rich = plain;
  rich.jitter = 2e-3;
  rich.duplicate = 0.3;
  rich.reorder = 0.3;
  const auto a = fates(plain, 2000), b = fates(rich, 2000);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(lost(a[i]), lost(b[i]));
}

TEST(LinkModel, EachDirectionEachClientAndEachSeedIsAnother) {
  LinkOptions half;
  half.loss = 0.5;
  const auto reference = fates(half, 1000, link_key(1, 0, LinkDirection::up));
  for (const std::uint64_t key :
       {link_key(1, 0, LinkDirection::down), link_key(1, 1, LinkDirection::up),
        link_key(2, 0, LinkDirection::up)}) {
    const auto other = fates(half, 1000, key);
    double same = 0.0;
    for (std::size_t i = 0; i < other.size(); ++i) same += lost(other[i]) == lost(reference[i]);
    EXPECT_THAT(same / 1000.0, share(0.5, 1000));
  }
}

TEST(LinkModel, NoTwoDirectionsShareAKey) {
  std::set<std::uint64_t> keys;
  for (std::uint64_t client = 0; client < 100; ++client)
    for (const LinkDirection direction : {LinkDirection::up, LinkDirection::down})
      keys.insert(link_key(1, client, direction));
  EXPECT_EQ(keys.size(), 200u);
}

struct Losses {
  double loss = 0.0, burst = 0.0;  // measured values
  double runs = 0.0, single = 0.0;
};
Losses measure(const std::vector<LinkFate>& all) {
  Losses m;
  double in_run = 0.0, count = 0.0;
  for (const LinkFate& fate : all) {
    if (lost(fate)) {
      ++count;
      ++in_run;
    } else if (in_run > 0.0) {
      ++m.runs;
      m.single += in_run == 1.0;
      in_run = 0.0;
    }
  }
  m.loss = count / static_cast<double>(all.size());
  m.burst = count / m.runs;
  return m;
}

TEST(LinkModel, LossesComeInRunsOfTheLengthAskedFor) {
  constexpr std::size_t kCount = 400'000;
  for (const auto& [loss, burst] :
       std::vector<std::pair<double, double>>{{0.01, 1}, {0.05, 4}, {0.3, 2}, {0.2, 20}}) {
    LinkOptions options;
    options.loss = loss;
    options.burst = burst;
    const Losses m = measure(fates(options, kCount));
    // Neighbours correlate by r = 1 - 1/B - p/(B (1 - p)). The number of independent values is
    // therefore smaller.
    const double r = 1.0 - 1.0 / burst - loss / (burst * (1.0 - loss));
    EXPECT_THAT(m.loss, share(loss, kCount * (1.0 - r) / (1.0 + r))) << loss << " " << burst;
    // Run lengths are geometric with mean B and variance B (B - 1). A share 1/B has length 1.
    EXPECT_NEAR(m.burst, burst, 4.0 * std::sqrt(burst * (burst - 1.0) / m.runs) + 1e-4);
    EXPECT_THAT(m.single / m.runs, share(1.0 / burst, m.runs));
  }
}

TEST(LinkModel, LossesAreIndependentUnlessRunsAreAskedFor) {
  LinkOptions options;
  options.loss = 0.3;
  const Losses m = measure(fates(options, 400'000));
  EXPECT_THAT(m.loss, share(0.3, 400'000));
  EXPECT_NEAR(m.burst, 1.0 / 0.7, 0.01);  // geometric distribution with 1 - p
}

TEST(LinkModel, AllIsLostOrNothing) {
  LinkOptions options;
  options.loss = 1.0;
  for (const LinkFate& fate : fates(options, 1000)) EXPECT_EQ(fate.loss, LinkFate::Loss::line);
}

TEST(LinkModel, TheFirstDatagramIsLostAsOftenAsAnyOther) {
  LinkOptions options;
  options.loss = 0.25;
  options.burst = 50;
  double first = 0.0;
  for (std::uint64_t key = 0; key < 20'000; ++key) first += lost(fates(options, 1, key)[0]);
  EXPECT_THAT(first / 20'000, share(0.25, 20'000));
}

TEST(LinkModel, JitterHasTheSameMeanAndDeviationInEachDistribution) {
  LinkOptions options;
  options.delay = 50e-3;
  options.jitter = 4e-3;
  options.keep_order = false;
  constexpr std::size_t kCount = 200'000;
  const double kError = options.jitter / std::sqrt(double{kCount});
  for (const Jitter distribution : {Jitter::normal, Jitter::uniform, Jitter::pareto}) {
    options.distribution = distribution;
    const auto all = delays(fates(options, kCount));
    EXPECT_NEAR(mean(all), 50e-3, 4.0 * kError);
    // The fourth moment of the Pareto distribution is infinite. The next test checks its quantiles
    // instead.
    if (distribution != Jitter::pareto) {
      EXPECT_NEAR(deviation(all), 4e-3, 8.0 * kError);
    }
  }
}

TEST(LinkModel, JitterHasTheQuantilesOfItsDistribution) {
  LinkOptions options;
  options.delay = 50e-3;
  options.jitter = 4e-3;
  options.keep_order = false;
  constexpr std::size_t kCount = 200'000;
  const auto below = [&](Jitter distribution, double deviations) {
    options.distribution = distribution;
    return share_below(delays(fates(options, kCount)), options.delay + deviations * options.jitter);
  };
  for (const double x : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
    const double normal = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    EXPECT_THAT(below(Jitter::normal, x), share(normal, kCount)) << x;
    const double uniform = std::clamp(0.5 + 0.5 * x / std::numbers::sqrt3, 0.0, 1.0);
    EXPECT_THAT(below(Jitter::uniform, x), share(uniform, kCount)) << x;
    // P(X < x) = 1 - (3/2 + x sqrt(3)/2)^-3 above the least value of X.
    const double scaled = 1.5 + x * 0.5 * std::numbers::sqrt3;
    const double pareto = scaled <= 1.0 ? 0.0 : 1.0 - std::pow(scaled, -3.0);
    EXPECT_THAT(below(Jitter::pareto, x), share(pareto, kCount)) << x;
  }
}

TEST(LinkModel, NoDatagramArrivesBeforeItEntered) {
  LinkOptions options;
  options.delay = 1e-3;
  options.jitter = 10e-3;
  options.keep_order = false;
  const auto all = delays(fates(options, 10'000));
  EXPECT_THAT(all, ::testing::Each(Ge(0.0)));
  // The model replaces negative delays by zero.
  EXPECT_THAT(share_below(all, 1e-12), share(0.5 * std::erfc(0.1 / std::numbers::sqrt2), 10'000));
}

TEST(LinkModel, OrderIsKeptAsALineKeepsIt) {
  LinkOptions options;
  options.delay = 25e-3;
  options.jitter = 5e-3;
  LinkOptions overtaking = options;
  overtaking.keep_order = false;
  const auto kept = fates(options, 5000), free = fates(overtaking, 5000);
  Nanoseconds latest{0};
  int overtaken = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    overtaken += free[i].arrivals[0] < latest;
    latest = std::max(latest, free[i].arrivals[0]);
    EXPECT_EQ(kept[i].arrivals[0], latest);
  }
  EXPECT_GT(overtaken, 2500);
}

TEST(LinkModel, AShareIsHeldBackAndTheLineDoesNotWait) {
  LinkOptions options;
  options.delay = 10e-3;
  options.reorder = 0.1;
  options.reorder_delay = 3.5e-3;
  double held = 0.0;
  for (const double delay : delays(fates(options, 20'000))) {
    if (delay > 0.011) {
      EXPECT_DOUBLE_EQ(delay, 13.5e-3);
      ++held;
    } else {
      EXPECT_DOUBLE_EQ(delay, 10e-3);
    }
  }
  EXPECT_THAT(held / 20'000, share(0.1, 20'000));
}

TEST(LinkModel, AShareArrivesTwiceEachWithItsOwnDelay) {
  LinkOptions options;
  options.delay = 10e-3;
  options.jitter = 1e-3;
  options.duplicate = 0.2;
  options.loss = 0.5;
  options.keep_order = false;
  double arrived = 0.0, twice = 0.0;
  for (const LinkFate& fate : fates(options, 20'000)) {
    arrived += fate.copies > 0;
    if (fate.copies != 2) continue;
    ++twice;
    EXPECT_NE(fate.arrivals[0], fate.arrivals[1]);
  }
  EXPECT_THAT(twice / arrived, share(0.2, arrived));
}

TEST(LinkModel, ABitRateSendsOneAfterTheOther) {
  LinkOptions options;
  // one datagram per millisecond
  options.rate = 8.0 * static_cast<double>(kSize + kHeadersOnTheWire) * 1e3;
  options.delay = 5e-3;
  const auto all = fates(options, 20, 1, Nanoseconds(0));
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(all[static_cast<std::size_t>(i)].arrivals[0],
              (i + 1) * kPeriod + std::chrono::milliseconds(5));
  // At the rate of the link no datagram waits.
  for (const double delay : delays(fates(options, 1000))) EXPECT_DOUBLE_EQ(delay, 6e-3);
}

TEST(LinkModel, AFullQueueDropsWhatComesLast) {
  constexpr double kOne = kSize + kHeadersOnTheWire;
  LinkOptions options;
  options.rate = 8.0 * kOne * 1e3;
  options.queue = 10.5 * kOne;
  const auto burst = fates(options, 15, 1, Nanoseconds(0));
  for (std::size_t i = 0; i < burst.size(); ++i)
    EXPECT_EQ(burst[i].loss, i < 10 ? LinkFate::Loss::none : LinkFate::Loss::queue) << i;
  // At twice the rate of the link, the full queue drops every second datagram.
  const auto twice = fates(options, 2000, 1, kPeriod / 2);
  const auto passed = 2000 - std::count_if(twice.begin(), twice.end(), lost);
  EXPECT_NEAR(static_cast<double>(passed), 1000 + 10, 1);
}

TEST(LinkModel, ATraceSaysWhatHappensAndBeginsAgain) {
  std::istringstream rows("t,delay,lost\n10,0.020,0\n10.1,0,1\n10.2,0.005,0\n");
  LinkOptions options;
  options.trace = std::make_shared<LinkTrace>(read_link_trace(rows, "rows"));
  options.keep_order = false;
  EXPECT_EQ(options.trace->period, std::chrono::milliseconds(300));
  LinkModel model(options, 1);
  const Nanoseconds start = std::chrono::seconds(77);
  for (int i = 0; i < 1200; ++i) {
    const Nanoseconds now = start + i * kPeriod;
    const LinkFate fate = model.next(kSize, now);
    const int phase = i % 300;
    if (phase >= 100 && phase < 200) {
      EXPECT_EQ(fate.loss, LinkFate::Loss::line) << i;
    } else {
      EXPECT_EQ(fate.arrivals[0] - now, std::chrono::milliseconds(phase < 100 ? 20 : 5)) << i;
    }
  }
}

}  // namespace
}  // namespace feltwire::link_model_test
