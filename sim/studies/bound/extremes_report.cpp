#include <nlohmann/json.hpp>

#include "core/base/choice.hpp"
#include "core/base/text.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/bound/extremes.hpp"

namespace feltwire {
namespace {

/// The methods that promise something, as the tables' columns.
constexpr std::array kColumns = {
    BoundingMode::contact_frame,     BoundingMode::energy_tank,
    BoundingMode::per_axis,          BoundingMode::virtual_coupling,
    BoundingMode::passivity_control, BoundingMode::passivity_control_directional};
constexpr const char* kHeads[] = {"contact_", "energy_",   "per_",
                                  "virtual_", "passivity", "pass.ctrl"};
constexpr const char* kHeads2[] = {"frame", "tank", "axis", "coupling", "control", "direction."};

nlohmann::ordered_json json(const ExtremeOutcome& o) {
  return {{"steps", o.steps},
          {"rendering", o.rendering},
          {"nan", o.nan},
          {"inf", o.inf},
          {"over_limit", o.over_limit},
          {"not_refused", o.not_refused},
          {"energy_error", o.energy_error},
          {"rounding", o.rounding},
          {"passed", o.passed()}};
}

/// Points of one method in one arithmetic: error over the strain's number. No error is drawn at the
/// foot.
std::string points(BoundingMode mode, const char* arithmetic, int method) {
  // Okabe and Ito's colours, told apart by colour-blind readers; points differ too.
  constexpr std::array kColors = {"#0072b2", "#e69f00", "#009e73", "#56b4e9", "#d55e00", "#cc79a7"};
  constexpr std::array kPoints = {7, 5, 9, 11, 13, 1};
  const auto i = static_cast<std::size_t>(method);
  const std::string label(name(mode));
  std::string text;
  append(text,
         "'extremes.csv' skip 1 using (int($0/%zu)%+.2f):(strcol(2) eq '%s' && strcol(3) ne 'none' "
         "&& strcol(4) eq '%s' ? ($11 > 1e-17 ? $11 : 1e-17) : NaN) ",
         2 * kBoundingModeNames.size(), 0.1 * (method - 2.5), label.c_str(), arithmetic);
  append(text, "with points pt %d ps 1.1 lc rgb '%s' %s%s%s", kPoints[i], kColors[i],
         arithmetic[0] == 'd' ? "title '" : "notitle", arithmetic[0] == 'd' ? label.c_str() : "",
         arithmetic[0] == 'd' ? "' noenhanced" : "");
  return text;
}

void draw(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows) {
  const std::size_t strains = rows.size() / kBoundingModeNames.size();
  std::string script =
      "set datafile separator ','\nset terminal pngcairo size 1300,820 font 'Sans,11'\n"
      "set output 'extremes.png'\n"
      "set title \"Energy missing of what each method promises, at the ends of what numbers can "
      "say\\nupper group of points: float; lower: double; at the foot: none missing\"\n"
      "set logscale y\nset format y '10^{%T}'\nset yrange [5e-18:1e-3]\n"
      "set ylabel 'missing, over all energy exchanged'\nset grid x lt 1 lc rgb '#dddddd'\n"
      "set key outside top right vertical samplen 1 title 'method'\nset tics nomirror\n"
      "set xtics rotate by -50 left noenhanced (";
  for (std::size_t i = 0; i < strains; ++i)
    append(script, "%s'%s' %zu", i ? ", " : "", rows[i * kBoundingModeNames.size()].strain.c_str(),
           i);
  append(script,
         ")\nset xrange [-1:%zu]\nplot %g with lines dt 2 lc rgb 'black' title 'epsilon of float', "
         "%g with lines dt 3 lc rgb 'black' title 'epsilon of double', \\\n",
         strains, kArithmetic<float>.epsilon, kArithmetic<double>.epsilon);
  for (std::size_t m = 0; m < kColumns.size(); ++m)
    script += points(kColumns[m], "double", static_cast<int>(m)) + ", \\\n" +
              points(kColumns[m], "float", static_cast<int>(m)) +
              (m + 1 < kColumns.size() ? ", \\\n" : "\n");
  plot(directory, "extremes", script);
}

}  // namespace

std::string extremes_table(const std::vector<ExtremeRow>& rows) {
  std::string text;
  for (const bool in_float : {false, true}) {
    append(text, "%s: worst energy missing of what the method promises, over all exchanged\n",
           in_float ? "float" : "double");
    append(text, "%-32s", "");
    for (const char* head : kHeads) append(text, " %10s", head);
    text += "    others\n";
    append(text, "%-32s", "");
    for (const char* head : kHeads2) append(text, " %10s", head);
    text += '\n';
    for (std::size_t first = 0; first < rows.size(); first += kBoundingModeNames.size()) {
      append(text, "%-32s", rows[first].strain.c_str());
      bool others = true;
      std::array<std::string, kColumns.size()> cells;
      for (std::size_t i = first; i < first + kBoundingModeNames.size(); ++i) {
        const ExtremeRow& row = rows[i];
        const ExtremeOutcome& o = in_float ? row.in_float : row.in_double;
        std::string cell;
        if (!o.passed())
          cell = "FAILED";
        else if (row.promise == Promise::none)
          cell = "-";
        else if (o.energy_error > 0.0)
          append(cell, "%.0e", o.energy_error);
        else
          cell = "0";
        bool shown = false;
        for (std::size_t c = 0; c < kColumns.size(); ++c)
          if (name(kColumns[c]) == row.method) cells[c] = cell, shown = true;
        if (!shown) others = others && o.passed();
      }
      for (const std::string& cell : cells) append(text, " %10s", cell.c_str());
      append(text, " %9s\n", others ? "ok" : "FAILED");
    }
    text += '\n';
  }
  text +=
      "-  promises no energy there; like the others (none, total_energy, per_axis_projected,\n"
      "   passivity_control_parallel) judged on NaN, Inf and the limit only, as every row is\n";
  for (const ExtremeRow& row : rows)
    for (const auto& [arithmetic, o] :
         {std::pair{"double", &row.in_double}, std::pair{"float", &row.in_float}})
      if (!o->passed())
        append(text,
               "FAILED  %s, %s, %s: %llu NaN, %llu Inf, %llu over the limit, %llu not refused; "
               "energy missing %.1e, rounding %.1e\n",
               row.strain.c_str(), std::string(row.method).c_str(), arithmetic,
               static_cast<unsigned long long>(o->nan), static_cast<unsigned long long>(o->inf),
               static_cast<unsigned long long>(o->over_limit),
               static_cast<unsigned long long>(o->not_refused), o->energy_error, o->rounding);
  return text;
}

void write_extremes(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "strain,method,promise,arithmetic,steps,rendering,nan,inf,over_limit,not_refused,"
      "energy_error,rounding,passed\n";
  auto document = nlohmann::ordered_json::array();
  for (const ExtremeRow& row : rows) {
    const std::string_view promised = name_among(kPromiseNames, row.promise);
    for (const auto& [arithmetic, o] :
         {std::pair{"double", &row.in_double}, std::pair{"float", &row.in_float}})
      append(csv, "%s,%s,%s,%s,%llu,%llu,%llu,%llu,%llu,%llu,%.3g,%.3g,%d\n", row.strain.c_str(),
             std::string(row.method).c_str(), std::string(promised).c_str(), arithmetic,
             static_cast<unsigned long long>(o->steps),
             static_cast<unsigned long long>(o->rendering), static_cast<unsigned long long>(o->nan),
             static_cast<unsigned long long>(o->inf),
             static_cast<unsigned long long>(o->over_limit),
             static_cast<unsigned long long>(o->not_refused), o->energy_error, o->rounding,
             o->passed());
    document.push_back({{"strain", row.strain},
                        {"method", row.method},
                        {"promise", promised},
                        {"double", json(row.in_double)},
                        {"float", json(row.in_float)}});
  }
  write_text(directory / "extremes.csv", csv);
  write_text(directory / "extremes.json", document.dump(1) + '\n');
  draw(directory, rows);
}

}  // namespace feltwire
