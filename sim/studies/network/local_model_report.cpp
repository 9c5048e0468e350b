#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/network/local_model_study.hpp"

namespace feltwire {
namespace {

const char* source(const LocalModelCell& cell) { return cell.modelled ? "model" : "forces"; }

std::vector<std::string> tasks_of(const std::vector<LocalModelCell>& cells) {
  std::vector<std::string> names;
  for (const LocalModelCell& cell : cells)
    if (std::ranges::find(names, cell.task) == names.end()) names.push_back(cell.task);
  return names;
}

/// Draws a panel for each task: the force error over the round-trip time. The last panel shows the
/// force error over the servo rate, for the cells with fewer datagrams than servo ticks.
void draw(const std::filesystem::path& directory, const std::vector<LocalModelCell>& cells) {
  constexpr std::size_t kColumns = 4;
  const std::vector<std::string> tasks = tasks_of(cells);
  constexpr std::size_t kRowHeight = 380;  // [pixels] height of a row of panels
  const std::size_t rows = (tasks.size() + kColumns) / kColumns;
  std::string script;
  append(script, "set terminal pngcairo size 1500,%zu font 'Sans,11'\n", rows * kRowHeight);
  script +=
      "set output 'local_model.png'\nset datafile separator ','\nset datafile missing NaN\nset "
      "grid lt 1 lc rgb '#dddddd'\nset "
      "tics nomirror\n";
  append(script, "set multiplot layout %zu,%zu title ", rows, kColumns);
  script +=
      "'Force on the hand against what the scene answers its true position: error over force, "
      "both RMS'\n"
      "set logscale y\nset yrange [0.03:300]\nset ylabel 'error [%]'\n"
      "set xlabel 'round trip [ms]'\nset key bottom right samplen 2\n";
  const auto curve = [&](const std::string& x, const std::string& task, bool thin_rows,
                         bool modelled) {
    std::string text;
    append(text, "'local_model.csv' skip 1 using ((strcol(1) eq '%s' && ", task.c_str());
    append(text, "($4 < 0.9 * $3) == %d && (%d || $3 == 1000) && strcol(5) eq '%s') ? ",
           thin_rows ? 1 : 0, thin_rows ? 1 : 0, modelled ? "model" : "forces");
    text += x + " : NaN):(100 * $7 / $6) with linespoints lw 1.6 ps 1.1 ";
    text += modelled ? "pt 7 lc rgb '#0072b2' title 'local model'"
                     : "pt 4 lc rgb '#d55e00' title 'forces alone'";
    return text;
  };
  for (const std::string& task : tasks) {
    append(script, "set title '%s'\nplot ", task.c_str());
    script += curve("$2", task, false, false) + ", " + curve("$2", task, false, true) + '\n';
    script += "unset key\n";
  }
  append(script,
         "set title 'ball, %g ms, %g datagrams/s'\nset logscale x\nset xtics (1, 4, 10)\n"
         "set xrange [0.8:12]\nset xlabel 'servo rate [kHz]'\nplot ",
         kUsualRoundTrip * kMilli, kThinRate);
  script += curve("$3/1e3", "ball", true, false) + ", " + curve("$3/1e3", "ball", true, true);
  plot(directory, "local_model", script + "\nunset multiplot\n");
}

}  // namespace

std::string local_model_table(const std::vector<LocalModelCell>& cells) {
  std::string text =
      "           round  rate   datagr  error [N] of force [N]  times    direction  displayed  "
      "onset  osc.  from   patches  down\n"
      "task       [ms]   [kHz]  [1/s]   forces   model  (model)  smaller  [deg]      [N/m]      "
      "[ms]   [um]  model           [kbit/s]\n";
  for (std::size_t i = 0; i + 1 < cells.size(); i += 2) {
    const LocalModelCell &plain = cells[i], &model = cells[i + 1];
    if (i > 0 && cells[i - 1].task != plain.task) text += '\n';
    append(text, "%-9s  %5g  %5g  %6.0f  %6.3f  %6.3f  %6.2f  %7.1f  ", plain.task.c_str(),
           plain.round_trip * kMilli, plain.rate / kMilli, plain.datagrams, plain.error,
           model.error, model.felt, plain.error / model.error);
    append(text, "%4.1f %4.1f  %4.0f %4.0f  %2.0f %2.0f  %3.0f %3.0f  %4.0f %%  %6.1f  %8.0f%s\n",
           plain.direction_error * kDegrees, model.direction_error * kDegrees, plain.displayed,
           model.displayed, plain.onset * kMilli, model.onset * kMilli, plain.oscillation * kMicro,
           model.oscillation * kMicro, kPercent * model.from_model, model.patches, model.kbit_down,
           plain.violations + model.violations > 0 ? "  VIOLATED" : "");
  }
  return text + "Pairs: forces alone, then the local model.\n";
}

void write_local_model(const std::filesystem::path& directory,
                       const std::vector<LocalModelCell>& cells) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "task,round_trip_ms,rate_hz,datagrams_per_s,source,felt_n,error_n,direction_error_deg,"
      "displayed_n_per_m,onset_ms,oscillation_um,from_model,patches,up_kbit_s,down_kbit_s,"
      "violations\n";
  auto document = nlohmann::ordered_json::array();
  for (const LocalModelCell& c : cells) {
    const double degrees = c.direction_error * kDegrees;
    append(csv, "%s,%g,%g,%.6g,%s,%.6g,%.6g,%.6g,", c.task.c_str(), c.round_trip * kMilli, c.rate,
           c.datagrams, source(c), c.felt, c.error, degrees);
    append(csv, "%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%llu\n", c.displayed, c.onset * kMilli,
           c.oscillation * kMicro, c.from_model, c.patches, c.kbit_up, c.kbit_down,
           static_cast<unsigned long long>(c.violations));
    document.push_back({{"task", c.task},
                        {"round_trip_ms", c.round_trip * kMilli},
                        {"rate_hz", c.rate},
                        {"datagrams_per_s", c.datagrams},
                        {"source", source(c)},
                        {"felt_n", c.felt},
                        {"error_n", c.error},
                        {"direction_error_deg", degrees},
                        {"displayed_n_per_m", c.displayed},
                        {"onset_ms", c.onset * kMilli},
                        {"oscillation_um", c.oscillation * kMicro},
                        {"from_model", c.from_model},
                        {"patches", c.patches},
                        {"up_kbit_s", c.kbit_up},
                        {"down_kbit_s", c.kbit_down},
                        {"violations", c.violations}});
  }
  write_text(directory / "local_model.csv", csv);
  write_text(directory / "local_model.json", document.dump(1) + '\n');
  draw(directory, cells);
}

}  // namespace feltwire
