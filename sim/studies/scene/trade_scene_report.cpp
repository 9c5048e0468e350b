#include <algorithm>

#include "core/base/text.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/scene/trade_scene.hpp"

namespace feltwire {
namespace {

constexpr double kThousand = 1e3, kHundred = 100.0;

/// Returns the extra time [%] of Scene::touch() over bare_touch(), relative to the time `of` [ns].
double share(const BareCost& bare, double of) { return kHundred * bare.more_ns / of; }

/// Returns the gnuplot text of a panel with a row for each case. `column` is on the horizontal
/// axis.
std::string column_panel(const char* label, const char* column, const char* colour) {
  std::string text;
  append(text, "set xlabel '%s'\n", label);
  append(text, "plot 'trade_scene.csv' skip 1 using (%s):0:ytic(1) with points pt 7 ps 1.4 ",
         column);
  return text + "lc rgb '" + colour + "'\n";
}

void draw_scene(const std::filesystem::path& directory, std::size_t rows) {
  constexpr int kHeight = 760;
  std::string styles =
      "set datafile separator comma\nset grid x y lt 1 lc rgb '#dddddd'\nset tics nomirror\n"
      "set logscale x\nset format x '%g'\nset nokey\nset ytics scale 0\n";
  append(styles, "set yrange [%g:-0.5]\n", static_cast<double>(rows) - 0.5);
  plot_pair(directory, "trade_scene", kHeight, styles,
            "Each by itself, under a hand that glides round a ball",
            column_panel("a sample [ns]", "$3", "#0072b2"),
            column_panel("the scene holds [kB]", "$7 / 1000", "#d55e00"));
}

}  // namespace

std::string trade_scene_table(std::span<const SceneCell> cells, const BareCost& bare) {
  std::string text =
      "                                      sample   to the     p99   tick      holds [kB]\n"
      "                             objects    [ns]     base    [ns]   [us]     scene  session\n";
  for (const SceneCell& c : cells) {
    append(text, "%-28s %7zu %7.0f %8.2f %7.0f", c.what.c_str(), c.objects, c.sample_ns, c.ratio,
           c.p99_ns);
    if (c.tick_ns > 0.0)
      append(text, " %6.1f", c.tick_ns / kThousand);
    else
      text += "      -";
    append(text, " %9.1f %8.1f\n", c.scene_bytes / kThousand, c.session_bytes / kThousand);
  }
  append(text, "\nThe base, contact and bound alone: %.1f ns; by code that knows nothing else %.1f",
         bare.product_ns, bare.bare_ns);
  append(text, " ns; more by %.2f ns,\n%.1f %% of these and %.1f %% of a sample.\n", bare.more_ns,
         share(bare, bare.bare_ns), share(bare, cells.front().sample_ns));
  return text;
}

void write_trade_scene(const std::filesystem::path& directory, std::span<const SceneCell> cells,
                       const BareCost& bare) {
  std::filesystem::create_directories(directory);
  std::string csv = "case,objects,sample_ns,ratio,p99_ns,tick_ns,scene_bytes,session_bytes\n";
  for (const SceneCell& c : cells) {
    append(csv, "\"%s\",%zu,%.4g,%.4g,%.4g,%.4g,", c.what.c_str(), c.objects, c.sample_ns, c.ratio,
           c.p99_ns, c.tick_ns);
    append(csv, "%.0f,%.0f\n", c.scene_bytes, c.session_bytes);
  }
  write_text(directory / "trade_scene.csv", csv);
  std::string pair = "bare_ns,product_ns,more_ns\n";
  append(pair, "%.4g,%.4g,%.4g\n", bare.bare_ns, bare.product_ns, bare.more_ns);
  write_text(directory / "trade_scene_bare.csv", pair);
  draw_scene(directory, cells.size());
}

}  // namespace feltwire
