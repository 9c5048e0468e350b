#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/scene/trade_tools.hpp"

namespace feltwire {
namespace {

constexpr double kNanoToMicro = 1e-3;

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kToolStyles =
    "set style line 1 lc rgb '#0072b2' pt 7 ps 1.3 lw 1.6\n"
    "set style line 2 lc rgb '#e69f00' pt 4 ps 1.7 lw 1.6\n"
    "set style line 3 lc rgb '#d55e00' pt 2 ps 1.5 lw 1.6\n"
    "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset logscale xy\nset format y '%g'\n"
    "set format x '10^{%T}'\n"
    "set xlabel 'points'\nset datafile separator ','\n";

/// Returns the gnuplot text of a panel: a column of a file over the number of points, with a curve
/// for each task.
std::string panel(const char* file, const char* column, const std::vector<ToolsCell>& cells) {
  std::string text = "plot ", last;
  int style = 1;
  for (const ToolsCell& c : cells) {
    if (c.task == last) continue;
    last = c.task;
    append(text, "'%s' skip 1 using (strcol(1) eq '%s' ? $2 : NaN):(%s)", file, c.task.c_str(),
           column);
    append(text, " with linespoints ls %d title '%s', ", style++, c.task.c_str());
  }
  return text + "NaN notitle\n";
}

void draw(const std::filesystem::path& directory, const std::vector<ToolsCell>& cells) {
  constexpr int kToolHeight = 520;
  plot_pair(
      directory, "trade_tools", kToolHeight, kToolStyles,
      "Points on a tool against a million of them",
      "set key top right\nset ylabel 'force error [%]'\n" + panel("trade_tools.csv", "$3", cells),
      "set ylabel 'torque error [% of force times radius]'\n" +
          panel("trade_tools.csv", "$4", cells));
  plot_pair(directory, "trade_tools_cost", kToolHeight, kToolStyles, "What a step takes",
            "set key top left\nset ylabel 'a step in contact [us]'\n" +
                panel("trade_tools_cost.csv", "$4", cells),
            "set nokey\nset ylabel 'a step 0.1 m away [us]'\nset yrange [0.01:1000]\n" +
                panel("trade_tools_cost.csv", "$3 > 0 ? $3 : NaN", cells));
}

}  // namespace

std::string trade_tools_table(const std::vector<ToolsCell>& cells) {
  std::string text =
      "                 force      torque    looked   points    contacts      step [us]\n"
      "task    points   error [%]  error [%]     at   inside    in a step     far  contact\n";
  for (const ToolsCell& c : cells) {
    if (&c != &cells.front() && c.task != (&c - 1)->task) text += '\n';
    append(text, "%-6s %7zu %9.3f %9.3f %9.0f %8.0f %10.1f ", c.task.c_str(), c.points,
           kPercent * c.force_error, kPercent * c.torque_error, c.looked_at, c.touching,
           c.evaluations);
    if (c.far_ns > 0.0)
      append(text, " %9.2f", kNanoToMicro * c.far_ns);
    else
      append(text, " %9s", "-");
    append(text, " %8.1f\n", kNanoToMicro * c.contact_ns);
  }
  return text;
}

void write_trade_tools(const std::filesystem::path& directory,
                       const std::vector<ToolsCell>& cells) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "task,points,force_error_percent,torque_error_percent,looked_at,touching,evaluations\n";
  std::string cost = "task,points,far_us,contact_us\n";
  auto document = nlohmann::ordered_json::array();
  for (const ToolsCell& c : cells) {
    append(csv, "%s,%zu,%.6g,%.6g,%.6g,%.6g,%.6g\n", c.task.c_str(), c.points,
           kPercent * c.force_error, kPercent * c.torque_error, c.looked_at, c.touching,
           c.evaluations);
    append(cost, "%s,%zu,%.4g,%.4g\n", c.task.c_str(), c.points, kNanoToMicro * c.far_ns,
           kNanoToMicro * c.contact_ns);
    document.push_back({{"task", c.task},
                        {"points", c.points},
                        {"force_error_percent", kPercent * c.force_error},
                        {"torque_error_percent", kPercent * c.torque_error},
                        {"looked_at", c.looked_at},
                        {"touching", c.touching},
                        {"evaluations", c.evaluations}});
  }
  write_text(directory / "trade_tools.csv", csv);
  write_text(directory / "trade_tools.json", document.dump(1) + '\n');
  write_text(directory / "trade_tools_cost.csv", cost);
  draw(directory, cells);
}

}  // namespace feltwire
