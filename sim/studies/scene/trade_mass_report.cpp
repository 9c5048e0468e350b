#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/scene/trade_mass.hpp"

namespace feltwire {
namespace {

constexpr double kToMilli = 1e3, kToGrams = 1e3;

// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kMassStyles =
    "set style line 1 lc rgb '#0072b2' pt 7 ps 1.3 lw 1.6\n"
    "set style line 2 lc rgb '#e69f00' pt 4 ps 1.7 lw 1.6\n"
    "set style line 3 lc rgb '#d55e00' pt 2 ps 1.5 lw 1.6\n"
    "set grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset logscale xy\nset format y '%g'\n"
    "set format x '%g'\nset datafile separator ','\n";

void draw_mass(const std::filesystem::path& directory) {
  constexpr int kMassHeight = 520;
  std::string error =
      "set key bottom right\nset xlabel 'mass [g]'\nset ylabel 'force error, swaying [%]'\nplot ";
  std::string left =
      "set key bottom left\nset xlabel 'stiffness of the plane [N/m]'\nset ylabel 'energy left "
      "after 3 s, tool of 100 g [%]'\nset yrange [1e-9:1000]\nplot ";
  int style = 1;
  for (const char* way : {"none", "implicit", "midpoint"}) {
    append(error,
           "'trade_mass.csv' skip 1 using (strcol(1) eq 'sway' && strcol(2) eq '%s' && $4 == 1 ? "
           "$3 : NaN):5 with linespoints ls %d title '%s', ",
           way, style, way);
    if (style > 1)
      append(left,
             "'trade_mass_stability.csv' skip 1 using (strcol(1) eq '%s' && $3 == 100 ? $2 : "
             "NaN):($5 > 1e-9 ? $5 : 1e-9) with linespoints ls %d title '%s', ",
             way, style, way);
    ++style;
  }
  plot_pair(directory, "trade_mass", kMassHeight, kMassStyles,
            "A tool with mass in steps of 1 ms: none, implicit, midpoint", error + "NaN notitle\n",
            left + "NaN notitle\n");
}

std::string mass_accuracy_table(const MassTrade& trade) {
  std::string text =
      "                        force error [%], a step of [ms]\ntask  mass [g]  way      ";
  for (const MassAccuracy& c : trade.accuracy) {
    if (c.mass != trade.accuracy.front().mass || c.way != trade.accuracy.front().way ||
        c.task != trade.accuracy.front().task)
      continue;
    append(text, "%9g", kToMilli * c.period);
  }
  // The table has a row for each task, mass and integration method, in the order of `accuracy`.
  for (const MassAccuracy& first : trade.accuracy) {
    if (first.period != trade.accuracy.front().period) continue;
    append(text, "\n%-5s %8g  %-9s", first.task.c_str(), kToGrams * first.mass, first.way.c_str());
    for (const MassAccuracy& c : trade.accuracy)
      if (c.task == first.task && c.mass == first.mass && c.way == first.way)
        append(text, "%9.3g", kPercent * c.force_error);
  }
  return text + '\n';
}

std::string mass_stability_table(const MassTrade& trade) {
  std::string text =
      "\nthrown onto a plane      largest energy over the first  |  at rest after [s], or energy "
      "left [%]\nway       mass [g]  ";
  const MassStability& front = trade.stability.front();
  for (int half = 0; half < 2; ++half) {
    for (const MassStability& c : trade.stability)
      if (c.way == front.way && c.mass == front.mass) append(text, "%7.0e", c.stiffness);
    text += half == 0 ? "  |" : "";
  }
  for (const MassStability& first : trade.stability) {
    if (first.stiffness != front.stiffness) continue;
    append(text, "\n%-9s %8g  ", first.way.c_str(), kToGrams * first.mass);
    const auto same = [&](const MassStability& c) {
      return c.way == first.way && c.mass == first.mass;
    };
    for (const MassStability& c : trade.stability)
      if (same(c)) append(text, "%7.4f", c.most);
    text += "  |";
    for (const MassStability& c : trade.stability) {
      if (!same(c)) continue;
      if (c.rests >= 0.0)
        append(text, "%7.3f", c.rests);
      else
        append(text, "%6.2g%%", kPercent * c.left);
    }
  }
  return text + '\n';
}

}  // namespace

std::string trade_mass_table(const MassTrade& trade) {
  std::string text = mass_accuracy_table(trade) + mass_stability_table(trade) +
                     "\ntask  way          p50 [ns]  p99 [ns]  contacts in a step\n";
  for (const MassCost& c : trade.cost)
    append(text, "%-5s %-9s %10.0f %9.0f %9.2f\n", c.task.c_str(), c.way.c_str(), c.median_ns,
           c.p99_ns, c.evaluations);
  return text;
}

void write_trade_mass(const std::filesystem::path& directory, const MassTrade& trade) {
  std::filesystem::create_directories(directory);
  std::string accuracy = "task,way,mass_g,period_ms,force_error_percent\n";
  for (const MassAccuracy& c : trade.accuracy)
    append(accuracy, "%s,%s,%g,%g,%.4g\n", c.task.c_str(), c.way.c_str(), kToGrams * c.mass,
           kToMilli * c.period, kPercent * c.force_error);
  std::string stability = "way,stiffness,mass_g,most_percent,left_percent,rests_s\n";
  for (const MassStability& c : trade.stability)
    append(stability, "%s,%g,%g,%.6g,%.4g,%.4g\n", c.way.c_str(), c.stiffness, kToGrams * c.mass,
           kPercent * c.most, kPercent * c.left, c.rests);
  std::string cost = "task,way,p50_ns,p99_ns,evaluations\n";
  for (const MassCost& c : trade.cost)
    append(cost, "%s,%s,%.4g,%.4g,%.4g\n", c.task.c_str(), c.way.c_str(), c.median_ns, c.p99_ns,
           c.evaluations);
  write_text(directory / "trade_mass.csv", accuracy);
  write_text(directory / "trade_mass_stability.csv", stability);
  write_text(directory / "trade_mass_cost.csv", cost);
  draw_mass(directory);
}

}  // namespace feltwire
