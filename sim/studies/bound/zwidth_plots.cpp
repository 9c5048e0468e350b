#include "sim/studies/bound/zwidth_plots.hpp"

#include "core/base/text.hpp"
#include "sim/report/plot.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kColumns = 5;

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr std::array kZwidthColors = {"#0072b2", "#009e73", "#e69f00", "#d55e00", "#cc79a7"};
constexpr std::array kPoints = {7, 5, 9, 13, 11};

std::string color(std::size_t delay) {
  return std::string(" lc rgb '") + kZwidthColors[delay % kZwidthColors.size()] + "'";
}
std::string marked(std::size_t delay) {
  std::string text = " with linespoints lw 1.8" + color(delay);
  append(text, " pt %d ps 0.9", kPoints[delay % kPoints.size()]);
  return text;
}

/// Returns the gnuplot text of a panel over the servo rate. Dashed lines: largest commanded
/// stiffness without oscillation. Solid lines: displayed stiffness.
std::string panel(const ZWidthGrid& grid, std::size_t method, std::size_t damping) {
  const std::size_t rates = grid.rates.size(), delays = grid.delays.size();
  std::string text = "set title '" + std::string(grid.methods[method].label) + "'\nplot ";
  for (std::size_t d = 0; d < delays; ++d) {
    const std::size_t first = (method * grid.dampings.size() + damping) * rates * delays + d;
    std::string rows;
    append(rows, "'zwidth.csv' skip 1 every %zu::%zu::%zu using ($3/1e3):", delays, first,
           first + (rates - 1) * delays);
    text += rows + "6 with lines dt 2 lw 1.2" + color(d) + ", " + rows + "8" + marked(d) +
            (d + 1 < delays ? ", " : "\n");
  }
  return text;
}

std::string legend(const ZWidthGrid& grid) {
  std::string text =
      "unset title\nunset border\nunset tics\nunset grid\nunset xlabel\nunset ylabel\n"
      "set key center center samplen 3 spacing 1.3 title 'round trip (whole samples, rounded up)'\n"
      "plot ";
  for (std::size_t d = 0; d < grid.delays.size(); ++d)
    append(text, "NaN%s title '%g ms', ", marked(d).c_str(), grid.delays[d] * 1e3);
  return text +
         "NaN with lines lw 1.8 lc rgb 'black' title 'displayed to the hand', "
         "NaN with lines lw 1.2 dt 2 lc rgb 'black' title 'largest commanded'\n";
}

}  // namespace

void draw_zwidth(const std::filesystem::path& directory, const ZWidthGrid& grid) {
  const std::size_t rows = grid.methods.size() / kColumns + 1;  // the legend also needs a panel
  for (std::size_t b = 0; b < grid.dampings.size(); ++b) {
    std::string name;
    append(name, "zwidth_b%g", grid.dampings[b]);
    std::string script;
    append(script,
           "set datafile separator ','\n"
           "set terminal pngcairo size 1800,%zu font 'Sans,11'\nset output '%s.png'\n",
           80 + 330 * rows, name.c_str());
    append(script,
           "set multiplot layout %zu,%zu title \"The stiffest wall without oscillation, device "
           "damping b = %g N s/m\"\n",
           rows, kColumns, grid.dampings[b]);
    append(script,
           "set grid lt 1 lc rgb '#dddddd'\nset logscale xy\nunset key\nset tics nomirror\n"
           "set xrange [%g:%g]\nset xtics (",
           grid.rates.front() / 1e3 * 0.85, grid.rates.back() / 1e3 * 1.15);
    for (const double rate : grid.rates)
      append(script, "%s%g", rate == grid.rates.front() ? "" : ", ", rate / 1e3);
    append(script,
           ")\nset xlabel 'servo rate [kHz]'\nset ylabel 'stiffness [N/m]'\n"
           "set yrange [50:%g]\nset format y '10^{%%T}'\n",
           grid.range.highest * 1.3);
    script += "set title noenhanced\n";
    for (std::size_t m = 0; m < grid.methods.size(); ++m) script += panel(grid, m, b);
    script += legend(grid) + "unset multiplot\n";
    plot(directory, name, script);
  }
}

}  // namespace feltwire
