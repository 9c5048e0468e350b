#pragma once
// Bandwidth against the force on the hand: the costs and gains of packet rate, batching,
// redundancy, deadbands, a local model and the servo rate over three links.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/session/profiles.hpp"

namespace feltwire {

/// The settings of a session.
struct TrafficSetting {
  std::string name;   // the varied setting, or the profile's name
  std::string group;  // "packet rate", "batching", ..., "all", "profile"
  SessionParameters parameters;
};

struct TradeLink {
  std::string_view name;
  std::string_view items;  // of parse_link()
};
inline constexpr TradeLink kTradeLinks[] = {
    {"near, 0.3 ms", "delay=0.15,jitter=0.03,loss=0.05"},
    {"far, 50 ms", "delay=25,jitter=2,distribution=pareto,loss=1,burst=3"},
    {"thin, 80 ms, 64 kbit/s", "delay=40,jitter=4,distribution=pareto,loss=1,rate=0.064,queue=4"}};

/// Every measured setting: one varied at a time about a baseline (1 kHz, every sample, k = 3, no
/// deadband, no model), most of them crossed, and the profiles. Each is valid by itself.
std::vector<TrafficSetting> traffic_settings();

/// Means over three tasks, each from its second 1 on: gliding round a ball of 1 kN/m, sliding over
/// a plane of 0.5 kN/m with friction, tapping on a plane of 1 kN/m.
struct TradeNetworkCell {
  std::size_t setting = 0, link = 0;
  double up_kbit = 0.0, down_kbit = 0.0;            // [kbit/s] with the headers of UDP and IPv4
  double up_datagrams = 0.0, down_datagrams = 0.0;  // [1/s]
  /// RMS of the held force less the scene's force at the true position at that moment, over the RMS
  /// of the latter.
  double force_error = 0.0;
  double direction_error = 0.0;  // [rad] mean angle between the two, if there are both
  /// [s] mean age of the felt force beyond the link's round trip: the time since the sample of the
  /// newest reply was taken.
  double added_delay = 0.0;
  double oscillation =
      0.0;              // [m] RMS of the true height, less a moving average of 51 ms; not of taps
  bool passive = true;  // no port delivered more than it burned
  /// [s] of computing for a second of session, on this machine and without the system calls. All
  /// other values are the same in every run.
  double server_time = 0.0, client_time = 0.0;
};

/// Every cell, links fastest. Deterministic. `duration` [s] of each task, above 1.
std::vector<TradeNetworkCell> run_trade_network(const std::vector<TrafficSetting>& settings,
                                                double duration);

/// The cells of a link that no other beats in both bandwidth and force error, cheapest first.
std::vector<std::size_t> pareto_front(const std::vector<TradeNetworkCell>& cells, std::size_t link);

/// Writes trade_network.csv, .json and .png, the same bytes every time, and apart from them the
/// computing time on this machine, trade_network_cost.csv. `directory` is created. Throws
/// std::runtime_error if something cannot be written or drawn.
void write_trade_network(const std::filesystem::path& directory,
                         const std::vector<TrafficSetting>& settings,
                         const std::vector<TradeNetworkCell>& cells);

/// Tables for people: one setting varied at a time, the front of each link, the profiles.
std::string trade_network_table(const std::vector<TrafficSetting>& settings,
                                const std::vector<TradeNetworkCell>& cells);
/// The computing time of each setting on the second link.
std::string trade_network_cost_table(const std::vector<TrafficSetting>& settings,
                                     const std::vector<TradeNetworkCell>& cells);

}  // namespace feltwire
