#include "sim/studies/bound/compare_plot.hpp"

#include <algorithm>

#include "core/base/text.hpp"
#include "sim/report/plot.hpp"

namespace feltwire {
namespace {

struct Panel {
  const char* title;
  int column;         // column of compare.csv
  const char* shade;  // gnuplot expression of the value v: 0 (white, good) to 1 (orange, bad)
  const char* label;  // gnuplot expression for the text of the value v
};
constexpr std::array kPanels = {
    Panel{"oscillation [um]: white up to 10 (what is felt) or the reference", 3,
          "log10(v/(calm > 10 ? 1.1*calm : 10))/1.5",
          "v < 9.95 ? sprintf('%.1f', v) : sprintf('%.0f', v)"},
    Panel{"direction error [degrees], mean", 4, "v/30", "sprintf('%.1f', v)"},
    Panel{"stiffness displayed / commanded", 5, "abs(1-v)", "sprintf('%.2f', v)"},
    Panel{"energy made [mJ]: 0 is passive", 6, "v > 0 ? (log10(v)+3)/5 : 0",
          "v < 0.005 ? '0' : v < 9.95 ? sprintf('%.2f', v) : sprintf('%.0f', v)"}};

}  // namespace

void draw_compare(const std::filesystem::path& directory, const std::vector<CompareRow>& rows,
                  const CompareLoop& loop) {
  if (rows.empty()) return;
  const auto methods = static_cast<std::size_t>(std::count_if(
      rows.begin(), rows.end(), [&](const CompareRow& r) { return r.task == rows.front().task; }));
  const std::size_t tasks = rows.size() / std::max<std::size_t>(1, methods);
  const auto last = static_cast<int>(methods) - 1;

  std::string script;
  append(script,
         "set datafile separator ','\n"
         "set terminal pngcairo size 1700,%zu font 'Sans,11'\nset output 'compare.png'\n",
         200 + 56 * (methods + 2));
  append(script,
         "set multiplot layout 2,2 title \"Every method on every surface: device damping %g N s/m, "
         "servo %g kHz, round trip %g ms\" font 'Sans,13'\n",
         loop.damping, loop.rate / 1e3, loop.delay * 1e3);
  append(
      script,
      "set lmargin 28\nunset key\nunset colorbox\nset tics scale 0\nset border 0\n"
      "calm = 0\nset palette defined (0 '#ffffff', 0.5 '#f7c873', 1 '#d55e00')\nset cbrange [0:1]\n"
      "set xrange [-0.5:%zu.5]\nset yrange [-0.5:%d.5]\nset xtics (",
      tasks - 1, last);
  for (std::size_t t = 0; t < tasks; ++t)
    append(script, "%s'%s' %zu", t == 0 ? "" : ", ", rows[t * methods].task.c_str(), t);
  script += ") noenhanced\nset ytics (";
  for (std::size_t m = 0; m < methods; ++m)
    append(script, "%s'%s' %d", m == 0 ? "" : ", ", rows[m].method.c_str(),
           last - static_cast<int>(m));
  script += ") noenhanced\nclip(x) = x < 0 ? 0 : x > 1 ? 1 : x\n";

  std::string cells;
  append(cells, "'compare.csv' skip 1 using (int($0)/%zu):(%d-int($0)%%%zu):", methods, last,
         methods);
  for (const Panel& panel : kPanels) {
    append(script, "set title '%s' noenhanced\nshade(v) = clip(%s)\nlabel(v) = %s\n", panel.title,
           panel.shade, panel.label);
    // The first row of each task is the reference. Its oscillation is stored in `calm`.
    append(script, "plot %s(calm = int($0)%%%zu == 0 ? $3 : calm, shade($%d)) with image, ",
           cells.c_str(), methods, panel.column);
    append(script, "%s(label($%d)) with labels\n", cells.c_str(), panel.column);
  }
  plot(directory, "compare", script + "unset multiplot\n");
}

}  // namespace feltwire
