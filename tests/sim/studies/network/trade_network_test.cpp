#include "sim/studies/network/trade_network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace feltwire::trade_network_test {
namespace {

TradeNetworkCell point(double kbit, double error, std::size_t link = 0) {
  TradeNetworkCell cell;
  cell.link = link;
  cell.up_kbit = 0.5 * kbit;
  cell.down_kbit = 0.5 * kbit;
  cell.force_error = error;
  return cell;
}

TEST(TradeNetwork, TheFrontIsWhatNothingBeats) {
  const std::vector<TradeNetworkCell> cells = {point(100, 0.5), point(50, 0.9),  point(200, 0.2),
                                               point(210, 0.2), point(60, 0.95), point(10, 0.1, 1),
                                               point(50, 0.8)};
  EXPECT_EQ(pareto_front(cells, 0), (std::vector<std::size_t>{6, 0, 2}));
  EXPECT_EQ(pareto_front(cells, 1), (std::vector<std::size_t>{5}));
  EXPECT_TRUE(pareto_front(cells, 2).empty());
}

TEST(TradeNetwork, EverySettingIsPossibleAndNamedOnce) {
  std::set<std::string> names;
  for (const TrafficSetting& s : traffic_settings()) {
    EXPECT_NO_THROW(validate(s.parameters)) << s.group << ' ' << s.name;
    EXPECT_TRUE(names.insert(s.group + s.name).second) << s.group << ' ' << s.name;
  }
  for (const NetworkProfile& profile : kNetworkProfiles)
    EXPECT_TRUE(names.contains("profile" + std::string(profile.name)));
}

std::vector<TrafficSetting> some(const std::vector<std::string>& names) {
  std::vector<TrafficSetting> wanted;
  for (const TrafficSetting& s : traffic_settings())
    if (std::ranges::find(names, s.group + ": " + s.name) != names.end()) wanted.push_back(s);
  EXPECT_EQ(wanted.size(), names.size());
  return wanted;
}

TEST(TradeNetwork, FewerDatagramsCostLessAndAddDelay) {
  const auto settings = some({"packet rate: 1000 Hz", "packet rate: 50 Hz"});
  const auto cells = run_trade_network(settings, 1.5);
  constexpr std::size_t kLinks = std::size(kTradeLinks);
  ASSERT_EQ(cells.size(), 2 * kLinks);
  for (std::size_t link = 0; link < kLinks; ++link) {
    const TradeNetworkCell &often = cells[link], &seldom = cells[kLinks + link];
    EXPECT_EQ(often.link, link);
    EXPECT_NEAR(often.up_datagrams, 1000, 2);
    EXPECT_NEAR(seldom.up_datagrams, 50, 2);
    EXPECT_LT(seldom.up_kbit, 0.06 * often.up_kbit);
    EXPECT_TRUE(often.passive && seldom.passive);
  }
  // A sample waits half an interval on average. The thin line has no room for every sample, so
  // samples wait longer.
  EXPECT_GT(cells[kLinks].added_delay, cells[0].added_delay + 5e-3);
  EXPECT_LT(cells[kLinks + 2].added_delay, cells[2].added_delay);
}

TEST(TradeNetwork, EveryRunIsTheSame) {
  const auto settings = some({"profile: lan"});
  const auto first = run_trade_network(settings, 1.5), second = run_trade_network(settings, 1.5);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].force_error, second[i].force_error);
    EXPECT_EQ(first[i].up_kbit, second[i].up_kbit);
    EXPECT_EQ(first[i].oscillation, second[i].oscillation);
  }
}

}  // namespace
}  // namespace feltwire::trade_network_test
