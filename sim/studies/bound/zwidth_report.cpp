#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "sim/studies/bound/zwidth.hpp"
#include "sim/studies/bound/zwidth_plots.hpp"

namespace feltwire {
namespace {

std::string csv(const std::vector<ZWidthCell>& cells) {
  std::string text =
      "method,damping,rate_hz,delay_ms,delay_samples,max_stiffness,above_range,displayed_at_max,"
      "displayed_at_5k,oscillation_at_5k_um\n";
  const auto number = [](std::optional<double> value) {
    std::string field;
    if (value) append(field, "%.6g", *value);
    return field;
  };
  for (const ZWidthCell& c : cells) {
    append(text, "%s,%g,%g,%g,%d,%.6g,%d,", std::string(c.method).c_str(), c.damping, c.rate,
           c.delay * 1e3, c.samples, c.limit.stiffness, c.limit.above_range ? 1 : 0);
    text += number(c.at_limit.displayed) + ',' + number(c.at_fixed.displayed);
    append(text, ",%.4g\n", c.at_fixed.oscillation * 1e6);
  }
  return text;
}

nlohmann::ordered_json optional_number(std::optional<double> value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

nlohmann::ordered_json json(const std::vector<ZWidthCell>& cells, const ZWidthGrid& grid) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const ZWidthCell& c : cells)
    list.push_back({{"method", c.method},
                    {"damping", c.damping},
                    {"rate_hz", c.rate},
                    {"delay_ms", c.delay * 1e3},
                    {"delay_samples", c.samples},
                    {"max_stiffness", c.limit.stiffness},
                    {"above_range", c.limit.above_range},
                    {"above_quantum_limit", c.limit.stiffness > quantum_limit()},
                    {"displayed_at_max", optional_number(c.at_limit.displayed)},
                    {"displayed_at_5k", optional_number(c.at_fixed.displayed)},
                    {"oscillation_at_5k_um", c.at_fixed.oscillation * 1e6}});
  return {{"oscillation_limit_um", kFeltOscillation * 1e6},
          {"lowest_stiffness", grid.range.lowest},
          {"highest_stiffness", grid.range.highest},
          {"tolerance", grid.range.tolerance},
          {"fixed_stiffness", kFixedStiffness},
          {"quantum_limit", quantum_limit()},
          {"cells", list}};
}

/// Returns the stiffness in kN/m with three digits, or "-" if no stiffness is displayed.
std::string kilo(std::optional<double> stiffness) {
  std::string text = "-";
  if (stiffness) {
    text.clear();
    append(text, "%.3g", *stiffness / 1e3);
  }
  return text;
}

/// Adds a line to `text` for each method and damping, from the cells for which `shown` returns
/// true. `with_fixed`: also adds the displayed stiffness of a wall of kFixedStiffness.
template <class Shown>
void lines(std::string& text, const std::vector<ZWidthCell>& cells, bool with_fixed,
           const Shown& shown) {
  std::string last;
  for (const ZWidthCell& c : cells) {
    if (!shown(c)) continue;
    std::string head;
    append(head, "\n%-29s %4g", std::string(c.method).c_str(), c.damping);
    if (head != last) text += head;
    last = head;
    append(text, " | %5s %5s", c.limit.above_range ? "any" : kilo(c.limit.stiffness).c_str(),
           kilo(c.at_limit.displayed).c_str());
    if (with_fixed) append(text, " %5s", kilo(c.at_fixed.displayed).c_str());
  }
  text += '\n';
}

/// Returns a table that counts the cells without oscillation for each method.
std::string counts(const std::vector<ZWidthCell>& cells) {
  std::string text =
      "\nOf all loops and devices, how many are calm\n"
      "method                         at 5 kN/m   at any stiffness\n";
  for (auto begin = cells.begin(); begin != cells.end();) {
    const auto end = std::find_if(begin, cells.end(),
                                  [&](const ZWidthCell& c) { return c.method != begin->method; });
    const auto at_fixed =
        std::count_if(begin, end, [](const ZWidthCell& c) { return c.at_fixed.calm(); });
    const auto any =
        std::count_if(begin, end, [](const ZWidthCell& c) { return c.limit.above_range; });
    append(text, "%-29s  %3td of %td   %3td of %td\n", std::string(begin->method).c_str(), at_fixed,
           end - begin, any, end - begin);
    begin = end;
  }
  return text;
}

}  // namespace

std::vector<ZWidthCell> write_zwidth(const std::filesystem::path& directory,
                                     const ZWidthGrid& grid) {
  std::filesystem::create_directories(directory);
  auto cells = map_zwidth(grid);
  write_text(directory / "zwidth.csv", csv(cells));
  write_text(directory / "zwidth.json", json(cells, grid).dump(1) + '\n');
  draw_zwidth(directory, grid);
  return cells;
}

std::string zwidth_table(const std::vector<ZWidthCell>& cells, const ZWidthGrid& grid) {
  std::string text =
      "Stiffness [kN/m]. max: the largest commanded without oscillation (any: the whole range). "
      "shown: what\nthe hand then meets. at 5: what it meets of 5 kN/m (-: it oscillates). b: the "
      "device's damping [N s/m].\n\n";
  append(text, "Round trip %g ms, by servo rate:\n", grid.delays.front() * 1e3);
  append(text, "%34s", "");
  for (const double rate : grid.rates) append(text, " | %7g kHz", rate / 1e3);
  append(text, "\n%-29s %4s", "method", "b");
  for (std::size_t i = 0; i < grid.rates.size(); ++i) text += " |   max shown";
  lines(text, cells, false, [&](const ZWidthCell& c) { return c.delay == grid.delays.front(); });
  const double rate = grid.rates[std::min<std::size_t>(1, grid.rates.size() - 1)];
  append(text, "\nAt %g kHz, by round trip:\n%34s", rate / 1e3, "");
  for (const double delay : grid.delays) append(text, " | %14g ms", delay * 1e3);
  append(text, "\n%-29s %4s", "method", "b");
  for (std::size_t i = 0; i < grid.delays.size(); ++i) text += " |   max shown  at 5";
  lines(text, cells, true, [&](const ZWidthCell& c) { return c.rate == rate; });
  text += counts(cells);
  return text;
}

}  // namespace feltwire
