#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/network/deadband_study.hpp"

namespace feltwire {
namespace {

std::string csv(const std::vector<DeadbandRow>& rows) {
  std::string text =
      "task,kind,k,saved,saved_up,saved_down,up_kbit_s,down_kbit_s,error_rms_n,error_max_n,"
      "relative,snr_db,least_margin_mj,violations\n";
  for (const DeadbandRow& r : rows) {
    append(text, "%s,%s,%g,%.4f,%.4f,%.4f,%.2f,%.2f,", r.task.c_str(), r.kind->name, r.fraction,
           r.saved, r.saved_up, r.saved_down, r.up_kbit, r.down_kbit);
    append(text, "%.6g,%.6g,%.6g,%.3f,%.6g,%llu\n", r.error_rms, r.error_max, r.relative, r.snr,
           kMilli * r.least_margin, static_cast<unsigned long long>(r.violations));
  }
  return text;
}

nlohmann::ordered_json json(const DeadbandGrid& grid, const std::vector<DeadbandRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const DeadbandRow& r : rows)
    list.push_back({{"task", r.task},
                    {"kind", r.kind->name},
                    {"k", r.fraction},
                    {"saved", r.saved},
                    {"saved_up", r.saved_up},
                    {"saved_down", r.saved_down},
                    {"up_kbit_s", r.up_kbit},
                    {"down_kbit_s", r.down_kbit},
                    {"error_rms_n", r.error_rms},
                    {"error_max_n", r.error_max},
                    {"relative", r.relative},
                    {"snr_db", std::isfinite(r.snr) ? nlohmann::ordered_json(r.snr) : nullptr},
                    {"least_margin_mj", kMilli * r.least_margin},
                    {"violations", r.violations}});
  return {{"side", name(grid.parameters.side)},
          {"servo_period_s", grid.parameters.servo_period},
          {"keep_alive_s", grid.parameters.keep_alive},
          {"hold_time_s", grid.parameters.hold_time},
          {"rows", list}};
}

/// Draws a panel for each task: the share of saved datagrams over the deadband k. A second row of
/// panels shows the force error.
void draw(const std::filesystem::path& directory, const std::vector<DeadbandRow>& rows) {
  std::vector<std::string> tasks;
  for (const DeadbandRow& r : rows)
    if (tasks.empty() || tasks.back() != r.task) tasks.push_back(r.task);
  std::string script;
  append(script,
         "set terminal pngcairo size %zu,760 font 'Sans,11'\nset output 'deadband.png'\n"
         "set datafile separator ','\nset datafile missing NaN\n",
         320 * tasks.size());
  script +=
      // Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
      "set style line 1 lc rgb '#0072b2' pt 7 ps 1.2 lw 1.6\n"
      "set style line 2 lc rgb '#e69f00' pt 4 ps 1.5 lw 1.6\n"
      "set style line 3 lc rgb '#d55e00' pt 2 ps 1.4 lw 1.6\n"
      "set style line 4 lc rgb '#009e73' pt 9 ps 1.4 lw 1.6\n"
      "set style line 5 lc rgb '#56b4e9' pt 5 ps 1.2 lw 1.6\n"
      "set style line 6 lc rgb '#cc79a7' pt 13 ps 1.6 lw 1.6\n"
      "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset xlabel 'k [%]'\n";
  append(script, "set multiplot layout 2,%zu title 'Datagrams that a deadband saves, and the ",
         tasks.size());
  script += "error of the force held against none'\n";
  for (const bool error : {false, true})
    for (const std::string& task : tasks) {
      append(script, "set title '%s'\nset ylabel '%s'\nset yrange [0:%s]\n%s\nplot ", task.c_str(),
             error ? "force error, RMS [% of the force]" : "datagrams saved, both ways [%]",
             error ? "*" : "100",
             !error && task == tasks.front() ? "set key top left" : "unset key");
      int style = 1;
      for (const DeadbandKind& kind : kDeadbandKinds) {
        append(script, "'deadband.csv' skip 1 using ($3*100):(strcol(1) eq '%s' && ", task.c_str());
        append(script, "strcol(2) eq '%s' ? 100*$%d : NaN) with linespoints ls %d title '%s', ",
               kind.name, error ? 11 : 4, style++, kind.name);
      }
      script += "NaN notitle\n";
    }
  plot(directory, "deadband", script + "unset multiplot\n");
}

}  // namespace

void write_deadband(const std::filesystem::path& directory, const DeadbandGrid& grid,
                    const std::vector<DeadbandRow>& rows) {
  std::filesystem::create_directories(directory);
  write_text(directory / "deadband.csv", csv(rows));
  write_text(directory / "deadband.json", json(grid, rows).dump(1) + '\n');
  draw(directory, rows);
}

std::string deadband_table(const std::vector<DeadbandRow>& rows) {
  std::string text =
      "                               datagrams saved [%]  bandwidth [kbit/s]  force error         "
      "           SNR   margin\n"
      "task          kind       k [%]    up  down  both         up    down  RMS [N]  max [N]  RMS "
      "[%]  [dB]  [mJ]     violations\n";
  const DeadbandRow* last = nullptr;
  for (const DeadbandRow& r : rows) {
    if (last != nullptr && (last->task != r.task || last->kind != r.kind)) text += '\n';
    append(text, "%-12s %-14s %4.1f %6.1f %5.1f %5.1f     %7.1f %7.1f", r.task.c_str(),
           r.kind->name, kPercent * r.fraction, kPercent * r.saved_up, kPercent * r.saved_down,
           kPercent * r.saved, r.up_kbit, r.down_kbit);
    append(text, "  %7.4f  %7.4f  %7.2f  %4.1f  %7.4f  %6llu\n", r.error_rms, r.error_max,
           kPercent * r.relative, r.snr, kMilli * r.least_margin,
           static_cast<unsigned long long>(r.violations));
    last = &r;
  }
  return text;
}

}  // namespace feltwire
