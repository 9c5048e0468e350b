#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/base/enum_names.hpp"
#include "core/base/text.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/bound/extremes.hpp"

namespace feltwire {
namespace {

/// Returns the number of methods in `rows`. The rows are sorted by stress test, then by method.
std::size_t method_count(const std::vector<ExtremeRow>& rows) {
  const auto other = std::find_if(rows.begin(), rows.end(), [&](const ExtremeRow& r) {
    return r.stress != rows.front().stress;
  });
  return static_cast<std::size_t>(other - rows.begin());
}

/// Returns the methods with an energy guarantee (Promise). They are the columns of the tables. The
/// strongest guarantee comes first.
std::vector<std::string_view> columns(const std::vector<ExtremeRow>& rows) {
  // The first stress test has no faults, so its rows have the strongest guarantee of each method.
  std::vector<ExtremeRow> promised;
  std::copy_if(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(method_count(rows)),
               std::back_inserter(promised),
               [](const ExtremeRow& r) { return r.promise != Promise::none; });
  std::stable_sort(promised.begin(), promised.end(),
                   [](const ExtremeRow& a, const ExtremeRow& b) { return a.promise < b.promise; });
  std::vector<std::string_view> methods;
  methods.reserve(promised.size());
  for (const ExtremeRow& r : promised) methods.push_back(r.method);
  return methods;
}

constexpr std::size_t kWidth = 10;  // [characters] width of a column

/// Returns the lines of the head of a column: the name of the method, divided after each
/// underscore.
std::vector<std::string> head(std::string_view method) {
  std::vector<std::string> lines;
  while (!method.empty()) {
    const std::string_view part = method.substr(0, method.find('_') + 1);
    const std::string_view line = part.empty() ? method : part;
    lines.emplace_back(line.size() <= kWidth ? line : line.substr(0, kWidth - 1));
    if (line.size() > kWidth) lines.back() += '.';
    method.remove_prefix(line.size());
  }
  return lines;
}

/// Returns the heads of all columns. The head with the most lines sets the height.
std::string heads(const std::vector<std::string_view>& methods) {
  std::size_t height = 1;
  for (const std::string_view method : methods) height = std::max(height, head(method).size());
  std::string text;
  for (std::size_t line = 0; line < height; ++line) {
    append(text, "%-32s", "");
    for (const std::string_view method : methods) {
      const auto lines = head(method);
      const std::size_t above = height - lines.size();
      append(text, " %10s", line < above ? "" : lines[line - above].c_str());
    }
    text += line == 0 ? "    others\n" : "\n";
  }
  return text;
}

/// Returns the names of the methods without an energy guarantee (Promise::none).
std::string others(const std::vector<ExtremeRow>& rows) {
  std::vector<std::string_view> methods;
  for (std::size_t i = 0; i < method_count(rows); ++i)
    if (rows[i].promise == Promise::none) methods.push_back(rows[i].method);
  return joined_names(methods, ", ");
}

/// Returns the table's entry for a method in a stress test.
std::string cell(const ExtremeRow& row, const ExtremeOutcome& o) {
  std::string text;
  if (!o.passed()) return "FAILED";
  if (o.steps == 0) return "not run";
  if (row.promise == Promise::none) return "-";
  if (!(o.energy_error > 0.0)) return "0";
  append(text, "%.0e", o.energy_error);
  return text;
}

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

/// Returns the gnuplot text for a method in an arithmetic (double or float): the energy error over
/// the index of the stress test. An error of zero is drawn at the lower edge.
std::string points(std::string_view mode, const char* arithmetic, std::size_t method,
                   std::size_t drawn, std::size_t methods) {
  // Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
  constexpr std::array kColors = {"#0072b2", "#e69f00", "#009e73", "#56b4e9", "#d55e00", "#cc79a7"};
  // After the colours begin anew, the points are hollow.
  constexpr std::array kPoints = {7, 5, 9, 11, 13, 1, 6, 4, 8, 10, 12, 2};
  const double middle = 0.5 * static_cast<double>(drawn - 1);
  const double aside = 0.8 * (static_cast<double>(method) - middle) / static_cast<double>(drawn);
  const std::string label(mode);
  std::string text;
  append(text,
         "'extremes.csv' skip 1 using (int($0/%zu)%+.2f):(strcol(2) eq '%s' && strcol(3) ne 'none' "
         "&& strcol(4) eq '%s' ? ($11 > 1e-17 ? $11 : 1e-17) : NaN) ",
         2 * methods, aside, label.c_str(), arithmetic);
  append(text, "with points pt %d ps 1.1 lc rgb '%s' %s%s%s", kPoints[method % kPoints.size()],
         kColors[method % kColors.size()], arithmetic[0] == 'd' ? "title '" : "notitle",
         arithmetic[0] == 'd' ? label.c_str() : "", arithmetic[0] == 'd' ? "' noenhanced" : "");
  return text;
}

}  // namespace

std::string extremes_table(const std::vector<ExtremeRow>& rows) {
  std::string text;
  const std::size_t methods = method_count(rows);
  const auto shown = columns(rows);
  for (const bool in_float : {false, true}) {
    append(text, "%s: worst energy missing of what the method promises, over all exchanged\n",
           in_float ? "float" : "double");
    text += heads(shown);
    for (std::size_t first = 0; first < rows.size(); first += methods) {
      append(text, "%-32s", rows[first].stress.c_str());
      bool others = true;
      std::vector<std::string> cells(shown.size());
      for (std::size_t i = first; i < first + methods; ++i) {
        const ExtremeOutcome& o = in_float ? rows[i].in_float : rows[i].in_double;
        const auto column = std::find(shown.begin(), shown.end(), rows[i].method);
        if (column == shown.end())
          others = others && o.passed();
        else
          cells[static_cast<std::size_t>(column - shown.begin())] = cell(rows[i], o);
      }
      for (const std::string& text_of : cells) append(text, " %10s", text_of.c_str());
      append(text, " %9s\n", others ? "ok" : "FAILED");
    }
    text += '\n';
  }
  const std::string unpromised = others(rows);
  text += "-  promises no energy there";
  if (!unpromised.empty()) text += "; like the others (" + unpromised + ")";
  text += "\n   judged on NaN, Inf and the limit only, as every row is\n";
  for (const ExtremeRow& row : rows)
    for (const auto& [arithmetic, o] :
         {std::pair{"double", &row.in_double}, std::pair{"float", &row.in_float}})
      if (!o->passed())
        append(text,
               "FAILED  %s, %s, %s: %llu NaN, %llu Inf, %llu over the limit, %llu not refused; "
               "energy missing %.1e, rounding %.1e\n",
               row.stress.c_str(), std::string(row.method).c_str(), arithmetic,
               static_cast<unsigned long long>(o->nan), static_cast<unsigned long long>(o->inf),
               static_cast<unsigned long long>(o->over_limit),
               static_cast<unsigned long long>(o->not_refused), o->energy_error, o->rounding);
  return text;
}

void write_extremes(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "stress,method,promise,arithmetic,steps,rendering,nan,inf,over_limit,not_refused,"
      "energy_error,rounding,passed\n";
  auto document = nlohmann::ordered_json::array();
  for (const ExtremeRow& row : rows) {
    const std::string_view promised = enum_name(kPromiseNames, row.promise);
    for (const auto& [arithmetic, o] :
         {std::pair{"double", &row.in_double}, std::pair{"float", &row.in_float}})
      append(csv, "%s,%s,%s,%s,%llu,%llu,%llu,%llu,%llu,%llu,%.3g,%.3g,%d\n", row.stress.c_str(),
             std::string(row.method).c_str(), std::string(promised).c_str(), arithmetic,
             static_cast<unsigned long long>(o->steps),
             static_cast<unsigned long long>(o->rendering), static_cast<unsigned long long>(o->nan),
             static_cast<unsigned long long>(o->inf),
             static_cast<unsigned long long>(o->over_limit),
             static_cast<unsigned long long>(o->not_refused), o->energy_error, o->rounding,
             o->passed());
    document.push_back({{"stress", row.stress},
                        {"method", row.method},
                        {"promise", promised},
                        {"double", json(row.in_double)},
                        {"float", json(row.in_float)}});
  }
  write_text(directory / "extremes.csv", csv);
  write_text(directory / "extremes.json", document.dump(1) + '\n');
}

void draw_extremes(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows) {
  const std::size_t methods = method_count(rows), stresses = rows.size() / methods;
  const auto drawn = columns(rows);
  std::string script =
      "set datafile separator ','\nset terminal pngcairo size 1300,820 font 'Sans,11'\n"
      "set output 'extremes.png'\n"
      "set title \"Energy missing of what each method promises, at the ends of what numbers can "
      "say\\nupper group of points: float; lower: double; at the bottom: none missing\"\n"
      "set logscale y\nset format y '10^{%T}'\nset yrange [5e-18:1e-3]\n"
      "set ylabel 'missing, over all energy exchanged'\nset grid x lt 1 lc rgb '#dddddd'\n"
      "set key outside top right vertical samplen 1 title 'method'\nset tics nomirror\n"
      "set xtics rotate by -50 left noenhanced (";
  for (std::size_t i = 0; i < stresses; ++i)
    append(script, "%s'%s' %zu", i ? ", " : "", rows[i * methods].stress.c_str(), i);
  append(script,
         ")\nset xrange [-1:%zu]\nplot %g with lines dt 2 lc rgb 'black' title 'epsilon of float', "
         "%g with lines dt 3 lc rgb 'black' title 'epsilon of double', \\\n",
         stresses, kArithmetic<float>.epsilon, kArithmetic<double>.epsilon);
  for (std::size_t m = 0; m < drawn.size(); ++m)
    script += points(drawn[m], "double", m, drawn.size(), methods) + ", \\\n" +
              points(drawn[m], "float", m, drawn.size(), methods) +
              (m + 1 < drawn.size() ? ", \\\n" : "\n");
  plot(directory, "extremes", script);
}

}  // namespace feltwire
