#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/bound/rate.hpp"

namespace feltwire {
namespace {

/// Returns the share [%] of a CPU core that a servo loop uses.
double load(double rate, const RateCost& cost, bool in_float) {
  return 100.0 * rate * 1e-9 *
         (cost.touch_ns + (in_float ? cost.bound_float_ns : cost.bound_double_ns));
}

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kStyles =
    "set style line 1 lc rgb '#0072b2' pt 7 ps 1.2 lw 1.6\n"
    "set style line 2 lc rgb '#e69f00' pt 4 ps 1.7 lw 1.6\n"
    "set style line 3 lc rgb '#d55e00' pt 2 ps 1.5 lw 1.6\n"
    "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset datafile separator ','\n"
    "set datafile missing NaN\n";  // a curve skips the rows of other curves

/// Returns the gnuplot text of a curve over the servo rate, from the rows of rate.csv with the
/// given surface, damping and arithmetic.
std::string curve(const std::string& surface, double damping, const std::string& arithmetic,
                  const char* column) {
  std::string text;
  append(text, "'rate.csv' skip 1 using ($3/1e3):(strcol(1) eq '%s' && $2 == %g && ",
         surface.c_str(), damping);
  append(text, "strcol(4) eq '%s' ? %s : NaN)", arithmetic.c_str(), column);
  return text;
}

struct RatePanel {
  const char* label;
  const char* column;
  const char* range;
};
constexpr RatePanel kRatePanels[] = {{"displayed stiffness [kN/m]", "$5/1e3", "[0.1:60]"},
                                     {"direction error [deg]", "$6", "[0:*]"},
                                     {"oscillation [um RMS]", "$7", "[0:10]"}};

std::vector<std::string> surfaces(const std::vector<RateCell>& cells) {
  std::vector<std::string> names;
  for (const RateCell& cell : cells)
    if (names.empty() || names.back() != cell.surface) names.push_back(cell.surface);
  return names;
}

void draw_rate(const std::filesystem::path& directory, const RateGrid& grid,
               const std::vector<RateCell>& cells) {
  std::string script =
      "set terminal pngcairo size 1500,1150 font 'Sans,11'\nset output 'rate.png'\n";
  script += kStyles;
  script +=
      "set multiplot layout 3,3 title 'What the servo rate and the arithmetic give a hand "
      "(contact\\_frame; whole line: b = 2 N s/m, dashed: 0.5)'\n"
      "set logscale x\nset xtics (0.25, 0.5, 1, 2, 4, 10, 20)\nset xrange [0.2:25]\n"
      "set xlabel 'servo rate [kHz]'\nset key bottom right samplen 3\n";
  for (const RatePanel& panel : kRatePanels)
    for (const std::string& surface : surfaces(cells)) {
      append(script, "set title '%s'\nset ylabel '%s'\n", surface.c_str(), panel.label);
      const bool first = panel.column == kRatePanels[0].column;
      script += std::string(first ? "set logscale y" : "unset logscale y") + "\nset yrange " +
                panel.range + "\n";
      script += first && surface == cells.front().surface ? "set key\nplot " : "unset key\nplot ";
      for (const double damping : grid.dampings) {
        int style = 1;
        const bool named = damping == grid.dampings.back();
        for (const RateArithmetic& a : kRateArithmetics) {
          script += curve(surface, damping, std::string(a.name), panel.column);
          append(script, " with linespoints ls %d dt %d %s%s%s, ", style++, named ? 1 : 2,
                 named ? "title '" : "notitle", named ? std::string(a.name).c_str() : "",
                 named ? "'" : "");
        }
      }
      script += "NaN notitle\n";
    }
  plot(directory, "rate", script + "unset multiplot\n");
}

/// Draws the displayed stiffness over the CPU time, with a point for each servo rate.
void draw_cost(const std::filesystem::path& directory, const RateGrid& grid,
               const std::vector<RateCell>& cells) {
  std::string script =
      "set terminal pngcairo size 1500,560 font 'Sans,11'\nset output 'rate_cost.png'\n";
  script += kStyles;
  script +=
      "set multiplot layout 1,3 title 'Stiffness against CPU time on one machine: up and to the "
      "left is better (whole line: b = 2 N s/m, dashed: 0.5; numbers: servo rate in kHz)'\n"
      "set logscale xy\nset yrange [0.1:60]\nset xlabel 'touch and bound, share of one core [%]'\n"
      "set ylabel 'displayed stiffness [kN/m]'\nset key bottom right samplen 3\n";
  for (const std::string& surface : surfaces(cells)) {
    append(script, "set title '%s'\nplot ", surface.c_str());
    for (const double damping : grid.dampings) {
      const bool named = damping == grid.dampings.back();
      for (const int style : {1, 2}) {
        std::string rows;
        append(rows, "(strcol(1) eq '%s' && $2 == %g && strcol(4) eq '%s' ? $6/1e3 : NaN)",
               surface.c_str(), damping, style == 1 ? "double" : "float");
        append(script, "'rate_cost.csv' skip 1 using 5:%s with linespoints ls %d dt %d %s, ",
               rows.c_str(), style, named ? 1 : 2,
               !named       ? "notitle"
               : style == 1 ? "title 'double'"
                            : "title 'float 0.1 m'");
        if (named && style == 1)
          append(script,
                 "'' skip 1 using 5:%s:(sprintf('%%g', $3/1e3)) with labels offset 0,1 notitle, ",
                 rows.c_str());
      }
    }
    script += "NaN notitle\n";
  }
  plot(directory, "rate_cost", script + "unset multiplot\n");
}

const RateCost& cost_of(const std::vector<RateCost>& costs, const std::string& surface) {
  for (const RateCost& cost : costs)
    if (cost.surface == surface) return cost;
  throw std::invalid_argument("no cost was measured on the surface '" + surface + "'");
}

}  // namespace

std::string rate_table(const std::vector<RateCell>& cells) {
  constexpr std::size_t kKinds = std::size(kRateArithmetics);
  std::string text =
      "               b       rate   displayed stiffness [N/m]  direction error [deg]  oscillation "
      "[um]\n"
      "surface        [Ns/m]  [kHz]   double    0.1 m      1 m  double   0.1 m     1 m  double  "
      "0.1 m    1 m\n";
  for (std::size_t i = 0; i + kKinds <= cells.size(); i += kKinds) {
    const RateCell& cell = cells[i];
    if (i > 0 && (cells[i - 1].surface != cell.surface || cells[i - 1].damping != cell.damping))
      text += '\n';
    append(text, "%-13s  %6.1f  %5.2f", cell.surface.c_str(), cell.damping, cell.rate / 1e3);
    for (std::size_t k = 0; k < kKinds; ++k) append(text, " %8.0f", cells[i + k].displayed);
    for (std::size_t k = 0; k < kKinds; ++k)
      append(text, " %7.3f", cells[i + k].direction_error * kDegrees);
    for (std::size_t k = 0; k < kKinds; ++k) append(text, " %6.2f", cells[i + k].oscillation * 1e6);
    text += '\n';
  }
  return text;
}

std::string rate_cost_table(const RateGrid& grid, const std::vector<RateCost>& costs) {
  std::string text =
      "               touch  bound [ns]         touch and bound in double, % of one core at [kHz]\n"
      "surface        [ns]   double  float ";
  for (const double rate : grid.rates) append(text, " %8g", rate / 1e3);
  text += '\n';
  for (const RateCost& cost : costs) {
    append(text, "%-13s  %5.0f  %6.0f  %5.0f ", cost.surface.c_str(), cost.touch_ns,
           cost.bound_double_ns, cost.bound_float_ns);
    for (const double rate : grid.rates) append(text, " %8.4f", load(rate, cost, false));
    text += '\n';
  }
  return text;
}

void write_rate(const std::filesystem::path& directory, const RateGrid& grid,
                const std::vector<RateCell>& cells, const std::vector<RateCost>& costs) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "surface,damping,rate_hz,arithmetic,displayed_n_per_m,direction_error_deg,oscillation_um\n";
  std::string cost_csv =
      "surface,damping,rate_hz,arithmetic,core_percent,displayed_n_per_m,touch_ns,bound_ns\n";
  auto document = nlohmann::ordered_json::array();
  for (const RateCell& cell : cells) {
    const std::string arithmetic(cell.arithmetic);
    const double degrees = cell.direction_error * kDegrees, micrometres = cell.oscillation * 1e6;
    append(csv, "%s,%g,%g,%s,%.6g,%.6g,%.6g\n", cell.surface.c_str(), cell.damping, cell.rate,
           arithmetic.c_str(), cell.displayed, degrees, micrometres);
    document.push_back({{"surface", cell.surface},
                        {"damping", cell.damping},
                        {"rate_hz", cell.rate},
                        {"arithmetic", arithmetic},
                        {"displayed_n_per_m", cell.displayed},
                        {"direction_error_deg", degrees},
                        {"oscillation_um", micrometres}});
  }
  write_text(directory / "rate.csv", csv);
  write_text(directory / "rate.json", document.dump(1) + '\n');
  draw_rate(directory, grid, cells);
  for (const RateCell& cell : cells) {
    const bool in_float = cell.arithmetic != kRateArithmetics[0].name;
    if (cell.arithmetic == kRateArithmetics[2].name) continue;  // same cost as at the other origin
    const RateCost& cost = cost_of(costs, cell.surface);
    append(cost_csv, "%s,%g,%g,%s,%.6g,%.6g,%.4g,%.4g\n", cell.surface.c_str(), cell.damping,
           cell.rate, in_float ? "float" : "double", load(cell.rate, cost, in_float),
           cell.displayed, cost.touch_ns, in_float ? cost.bound_float_ns : cost.bound_double_ns);
  }
  write_text(directory / "rate_cost.csv", cost_csv);
  draw_cost(directory, grid, cells);
}

}  // namespace feltwire
