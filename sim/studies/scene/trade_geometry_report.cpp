#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/scene/trade_geometry.hpp"

namespace feltwire {
namespace {

std::string size_text(const GeometryCell& cell) {
  std::string text;
  if (cell.size >= 1.0) append(text, "%.0f tri", cell.size);
  if (cell.size > 0.0 && cell.size < 1.0) append(text, "%g mm", cell.size * kMilli);
  return text;
}

constexpr double kMega = 1e6;

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kStyles =
    "set style line 1 lc rgb '#000000' pt 3 ps 2.0 lw 1.6\n"
    "set style line 2 lc rgb '#0072b2' pt 7 ps 1.3 lw 1.6\n"
    "set style line 3 lc rgb '#e69f00' pt 4 ps 1.7 lw 1.6\n"
    "set style line 4 lc rgb '#d55e00' pt 2 ps 1.5 lw 1.6\n"
    "set style line 5 lc rgb '#009e73' pt 8 ps 1.7 lw 1.6\n"
    "set style line 6 lc rgb '#56b4e9' pt 6 ps 1.7 lw 1.6\n"
    "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset logscale xy\nset format xy '%g'\n";

struct Curve {
  const char* kind;
  const char* arithmetic;
  int style;
};
constexpr Curve kCurves[] = {{"analytic", "double", 1},       {"mesh, nearest", "double", 2},
                             {"mesh, proxy", "double", 6},    {"grid, linear", "float", 3},
                             {"grid, quadratic", "float", 4}, {"grid, quadratic", "double", 5}};

/// Returns the gnuplot text of a panel: a data block with the points (x, y) of each curve, and the
/// plot command.
template <class X, class Y>
std::string panel(const std::vector<GeometryCell>& cells, int number, const X& x, const Y& y) {
  std::string data, plots = "plot ";
  for (const Curve& curve : kCurves) {
    append(data, "$p%dc%d << END\n", number, curve.style);
    for (const GeometryCell& c : cells)
      if (c.kind == curve.kind && c.arithmetic == curve.arithmetic)
        append(data, "%.6g %.6g\n", x(c), y(c));
    data += "END\n";
    append(plots, "$p%dc%d with linespoints ls %d title '%s", number, curve.style, curve.style,
           curve.kind);
    append(plots, "%s', ",
           curve.kind[0] == 'g' ? (std::string(", ") + curve.arithmetic).c_str() : "");
  }
  return data + plots + "NaN notitle\n";
}

// A logarithmic axis has no zero, so an error of zero is drawn at these values.
constexpr double kFloorDegrees = 1e-6, kFloorNewton = 1e-9, kFloorPercent = 1e-8;
double degrees(const GeometryCell& c) {
  return std::max(kFloorDegrees, c.direction_error * kDegrees);
}

void draw(const std::filesystem::path& directory, const std::vector<GeometryCell>& cells) {
  constexpr int kHeight = 560;
  plot_pair(directory, "trade_geometry", kHeight, kStyles,
            "A ball of 90 mm and 5 kN/m, felt 2 mm deep",
            "set key bottom left\nset xlabel 'direction error, mean [deg]'\n"
            "set ylabel 'force error, RMS over RMS [%]'\n" +
                panel(cells, 1, degrees,
                      [](const GeometryCell& c) {
                        return std::max(kFloorPercent, kPercent * c.force_error);
                      }),
            "set nokey\nset ylabel 'largest jump of the force beyond its own [N]'\n" +
                panel(cells, 2, degrees,
                      [](const GeometryCell& c) { return std::max(kFloorNewton, c.jump); }));
  plot_pair(
      directory, "trade_geometry_cost", kHeight, kStyles,
      "A ball of 90 mm, felt 2 mm deep: down and to the left is better",
      "set key top left\nset ylabel 'direction error, mean [deg]'\nset xlabel 'memory [MB]'\n" +
          panel(
              cells, 1, [](const GeometryCell& c) { return c.bytes / kMega; }, degrees),
      "set nokey\nset xlabel 'a query, gliding [ns]'\n" +
          panel(
              cells, 2, [](const GeometryCell& c) { return c.glide_ns; }, degrees));
}

}  // namespace

std::string trade_geometry_table(const std::vector<GeometryCell>& cells) {
  std::string text =
      "                                       direction [deg]      force      jump    query [ns]   "
      "  "
      "memory  build\n"
      "kind             arithmetic  size         mean    worst   error [%]      [N]  glide  "
      "scattered   [MB]    [s]\n";
  for (const GeometryCell& c : cells) {
    append(text, "%-16s %-10s %12s %9.2g %8.2g %10.2g %9.2g", c.kind.c_str(), c.arithmetic.c_str(),
           size_text(c).c_str(), c.direction_error * kDegrees, c.worst_direction * kDegrees,
           kPercent * c.force_error, c.jump);
    append(text, " %6.0f %10.0f %7.3g %6.2f\n", c.glide_ns, c.scattered_ns, c.bytes / kMega,
           c.build);
  }
  return text;
}

void write_trade_geometry(const std::filesystem::path& directory,
                          const std::vector<GeometryCell>& cells) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "kind,arithmetic,size,direction_mean_deg,direction_max_deg,force_error_percent,jump_n\n";
  std::string cost = "kind,arithmetic,size,glide_ns,scattered_ns,bytes,build_s\n";
  auto document = nlohmann::ordered_json::array();
  for (const GeometryCell& c : cells) {
    const double mean = c.direction_error * kDegrees, worst = c.worst_direction * kDegrees;
    append(csv, "\"%s\",%s,%g,%.6g,%.6g,%.6g,%.6g\n", c.kind.c_str(), c.arithmetic.c_str(), c.size,
           mean, worst, kPercent * c.force_error, c.jump);
    append(cost, "\"%s\",%s,%g,%.4g,%.4g,%.0f,%.4g\n", c.kind.c_str(), c.arithmetic.c_str(), c.size,
           c.glide_ns, c.scattered_ns, c.bytes, c.build);
    document.push_back({{"kind", c.kind},
                        {"arithmetic", c.arithmetic},
                        {"size", c.size},
                        {"direction_mean_deg", mean},
                        {"direction_max_deg", worst},
                        {"force_error_percent", kPercent * c.force_error},
                        {"jump_n", c.jump}});
  }
  write_text(directory / "trade_geometry.csv", csv);
  write_text(directory / "trade_geometry.json", document.dump(1) + '\n');
  write_text(directory / "trade_geometry_cost.csv", cost);
  draw(directory, cells);
}

}  // namespace feltwire
