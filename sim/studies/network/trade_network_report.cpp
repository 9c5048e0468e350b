#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/network/trade_network.hpp"

namespace feltwire {
namespace {

using TrafficSettings = std::vector<TrafficSetting>;
using Cells = std::vector<TradeNetworkCell>;

constexpr std::size_t kLinks = std::size(kTradeLinks);

std::string csv(const TrafficSettings& settings, const Cells& cells) {
  std::string text =
      "group,setting,link,servo_hz,packet_interval,batch,redundancy,position_deadband,"
      "force_deadband,predictor,local_model,up_kbit_s,down_kbit_s,up_datagrams_s,down_datagrams_s,"
      "force_error,direction_error_deg,added_delay_ms,oscillation_um,passive\n";
  for (const TradeNetworkCell& c : cells) {
    const TrafficSetting& s = settings[c.setting];
    const SessionParameters& p = s.parameters;
    append(text, "\"%s\",\"%s\",\"%s\",%.0f,%d,%d,%d,%g,%g,%s,%d,", s.group.c_str(), s.name.c_str(),
           kTradeLinks[c.link].name.data(), 1.0 / p.servo_period, p.packet_interval, p.batch,
           p.redundancy, p.position_deadband, p.force_deadband, name(p.predictor).data(),
           p.local_model ? 1 : 0);
    append(text, "%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d\n", c.up_kbit, c.down_kbit,
           c.up_datagrams, c.down_datagrams, c.force_error, kDegrees * c.direction_error,
           kMilli * c.added_delay, kMicro * c.oscillation, c.passive ? 1 : 0);
  }
  return text;
}

std::string cost_csv(const TrafficSettings& settings, const Cells& cells) {
  std::string text = "group,setting,link,server_us_per_s,client_us_per_s\n";
  for (const TradeNetworkCell& c : cells)
    append(text, "\"%s\",\"%s\",\"%s\",%.0f,%.0f\n", settings[c.setting].group.c_str(),
           settings[c.setting].name.c_str(), kTradeLinks[c.link].name.data(),
           kMicro * c.server_time, kMicro * c.client_time);
  return text;
}

nlohmann::ordered_json json(const TrafficSetting& s, const TradeNetworkCell& c) {
  const SessionParameters& p = s.parameters;
  return {{"group", s.group},
          {"setting", s.name},
          {"link", kTradeLinks[c.link].name},
          {"servo_hz", 1.0 / p.servo_period},
          {"packet_interval", p.packet_interval},
          {"batch", p.batch},
          {"redundancy", p.redundancy},
          {"position_deadband", p.position_deadband},
          {"force_deadband", p.force_deadband},
          {"predictor", name(p.predictor)},
          {"local_model", p.local_model},
          {"up_kbit_per_s", c.up_kbit},
          {"down_kbit_per_s", c.down_kbit},
          {"up_datagrams_per_s", c.up_datagrams},
          {"down_datagrams_per_s", c.down_datagrams},
          {"force_error", c.force_error},
          {"direction_error_deg", kDegrees * c.direction_error},
          {"added_delay_ms", kMilli * c.added_delay},
          {"oscillation_um", kMicro * c.oscillation},
          {"passive", c.passive}};
}

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kStyles =
    "set style line 1 lc rgb '#0072b2' pt 7 ps 1.0\n"
    "set style line 2 lc rgb '#e69f00' pt 5 ps 1.0\n"
    "set style line 3 lc rgb '#999999' lw 1.5\n"
    "set style line 4 lc rgb '#d55e00' pt 3 ps 2.0 lw 2\n"
    "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\n";

/// Returns a gnuplot data block with a point for each cell of a link for which `take` returns true.
template <class Take>
std::string points(const char* block, const TrafficSettings& settings, const Cells& cells,
                   std::size_t link, const Take& take) {
  std::string text = std::string("$") + block + " << END\n";
  for (const TradeNetworkCell& c : cells)
    if (c.link == link && take(settings[c.setting]))
      append(text, "%.6g %.6g \"%s\"\n", c.up_kbit + c.down_kbit, kPercent * c.force_error,
             settings[c.setting].name.c_str());
  return text + "END\n";
}

void draw(const std::filesystem::path& directory, const TrafficSettings& settings,
          const Cells& cells) {
  std::string script =
      "set terminal pngcairo size 1600,620 font 'Sans,11'\nset output 'trade_network.png'\n";
  script += kStyles;
  script +=
      "set multiplot layout 1,3 title 'Bandwidth against force error: down and to the left is "
      "better'\nset logscale xy\nset xrange [10:10000]\nset yrange [1:1000]\nset xlabel 'both ways "
      "together [kbit/s]'\n"
      "set ylabel 'force error, RMS over RMS [%]'\nset key top right\n";
  for (std::size_t link = 0; link < kLinks; ++link) {
    const auto profile = [](const TrafficSetting& s) { return s.group == "profile"; };
    script += points("forces", settings, cells, link, [&](const TrafficSetting& s) {
      return !profile(s) && !s.parameters.local_model;
    });
    script += points("models", settings, cells, link, [&](const TrafficSetting& s) {
      return !profile(s) && s.parameters.local_model;
    });
    script += points("profiles", settings, cells, link, profile);
    script += "$front << END\n";
    for (const std::size_t i : pareto_front(cells, link))
      append(script, "%.6g %.6g\n", cells[i].up_kbit + cells[i].down_kbit,
             kPercent * cells[i].force_error);
    append(script,
           "END\nset title '%s'\nplot $front with steps ls 3 title 'front', "
           "$forces using 1:2 with points ls 1 title 'forces alone', ",
           kTradeLinks[link].name.data());
    script +=
        "$models using 1:2 with points ls 2 title 'local model', "
        "$profiles using 1:2 with points ls 4 title 'profiles', "
        "$profiles using 1:2:3 with labels offset 0,-1.2 notitle\n";
  }
  plot(directory, "trade_network", script + "unset multiplot\n");
}

constexpr const char* kHead =
    "                                       up      down    datagrams     force   direction  added "
    "  "
    "oscil-\n"
    "                                   [kbit/s]  [kbit/s]  up / down     error     error    delay "
    "  "
    "lation\n"
    "                                                         [1/s]         [%]     [deg]     [ms] "
    "    "
    "[um]\n";

void append_row(std::string& table, const TrafficSetting& s, const TradeNetworkCell& c) {
  append(table, "  %-32s %8.0f  %8.0f  %4.0f / %4.0f  %8.1f  %8.2f  %7.1f  %7.1f%s\n",
         s.name.c_str(), c.up_kbit, c.down_kbit, c.up_datagrams, c.down_datagrams,
         kPercent * c.force_error, kDegrees * c.direction_error, kMilli * c.added_delay,
         kMicro * c.oscillation, c.passive ? "" : "  NOT PASSIVE");
}

}  // namespace

void write_trade_network(const std::filesystem::path& directory, const TrafficSettings& settings,
                         const Cells& cells) {
  std::filesystem::create_directories(directory);
  write_text(directory / "trade_network.csv", csv(settings, cells));
  write_text(directory / "trade_network_cost.csv", cost_csv(settings, cells));
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const TradeNetworkCell& cell : cells) all.push_back(json(settings[cell.setting], cell));
  write_text(directory / "trade_network.json", all.dump(1) + '\n');
  draw(directory, settings, cells);
}

std::string trade_network_table(const TrafficSettings& settings, const Cells& cells) {
  std::string table;
  for (std::size_t link = 0; link < kLinks; ++link) {
    append(table, "%s%s  (%s, each way)\n", link > 0 ? "\n" : "", kTradeLinks[link].name.data(),
           kTradeLinks[link].items.data());
    table += kHead;
    std::string group;
    for (const TradeNetworkCell& cell : cells) {
      const TrafficSetting& s = settings[cell.setting];
      if (cell.link != link || s.group == "all") continue;
      if (s.group != group) append(table, "%s\n", s.group.c_str());
      group = s.group;
      append_row(table, s, cell);
    }
    table += "the front: nothing that was measured beats these in both bandwidth and force error\n";
    for (const std::size_t i : pareto_front(cells, link))
      append_row(table, settings[cells[i].setting], cells[i]);
  }
  return table;
}

std::string trade_network_cost_table(const TrafficSettings& settings, const Cells& cells) {
  constexpr std::size_t kLink = 1;
  std::string table = "computing for a second of session, without system calls [us]\n";
  append(table, "  %-32s %8s  %8s\n", "", "server", "client");
  std::string group;
  for (const TradeNetworkCell& cell : cells) {
    const TrafficSetting& s = settings[cell.setting];
    if (cell.link != kLink || s.group == "all") continue;
    if (s.group != group) append(table, "%s\n", s.group.c_str());
    group = s.group;
    append(table, "  %-32s %8.0f  %8.0f\n", s.name.c_str(), kMicro * cell.server_time,
           kMicro * cell.client_time);
  }
  return table;
}

}  // namespace feltwire
