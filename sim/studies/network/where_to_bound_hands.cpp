#include <algorithm>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/network/where_to_bound.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kHands = kEightHands.size();

std::vector<double> over_hands(const WhereToBoundCell* first, double WhereToBoundCell::*value) {
  std::vector<double> values;
  for (const WhereToBoundCell* cell = first; cell != first + kHands; ++cell)
    values.push_back(cell->*value);
  return values;
}

}  // namespace

void write_where_to_bound_hands(const std::filesystem::path& directory,
                                const std::vector<WhereToBoundCell>& cells) {
  std::string text =
      "task,bound,hand,round_trip_ms,loss_percent,oscillation_um,displayed_n_per_m,"
      "direction_mean_deg,margin_j,violations,device_margin_j\n";
  for (const WhereToBoundCell& c : cells)
    append(text, "%s,%s,%s,%g,%g,%.4g,%.5g,%.4g,%.4g,%llu,%.4g\n", std::string(c.task).c_str(),
           std::string(c.bound).c_str(), std::string(c.hand).c_str(), c.round_trip * kMilli,
           c.loss.loss * kPercent, c.oscillation * kMicro, c.displayed, c.direction_mean * kDegrees,
           c.margin, static_cast<unsigned long long>(c.violations), c.device_margin);
  write_text(directory / "sides_hands.csv", text);
}

std::string where_to_bound_hands_table(const std::vector<WhereToBoundCell>& cells) {
  std::string text = "\nBy eight hands, no jitter, no loss: the median of the hands / the worst\n";
  std::string_view task;
  for (std::size_t i = 0; i + kHands <= cells.size(); i += kHands) {
    // A row of the table shows all four bounds, but their cells are not adjacent. The cell of the
    // first bound begins the row.
    const WhereToBoundCell& c = cells[i];
    if (c.bound != kSidesBounds[0] || !clean(c)) continue;
    if (c.task != task) {
      append(text, "\n%s\nround     oscillation [um RMS]%52s displayed [N/m]\ntrip, ms ",
             std::string(c.task).c_str(), "");
      for (int column = 0; column < 2; ++column)
        for (const std::string_view bound : kSidesBounds)
          append(text, column ? " %13s" : " %17s", std::string(bound).c_str());
      text += '\n';
      task = c.task;
    }
    std::string oscillation, displayed;
    for (const std::string_view bound : kSidesBounds)
      for (std::size_t n = 0; n + kHands <= cells.size(); n += kHands) {
        const WhereToBoundCell& o = cells[n];
        if (o.task != c.task || o.bound != bound || o.round_trip != c.round_trip || !clean(o))
          continue;
        const auto shakes = over_hands(&o, &WhereToBoundCell::oscillation);
        const auto shown = over_hands(&o, &WhereToBoundCell::displayed);
        append(oscillation, " %8.1f /%7.1f", median(shakes) * kMicro,
               std::ranges::max(shakes) * kMicro);
        append(displayed, " %6.0f /%5.0f", median(shown), std::ranges::min(shown));
      }
    append(text, "%8g  %s %s\n", c.round_trip * kMilli, oscillation.c_str(), displayed.c_str());
  }
  text += "\nRuns by eight hands in which more energy was given than the device burned\n";
  for (const std::string_view bound : kSidesBounds) {
    const auto of = [&](const WhereToBoundCell& c) { return c.bound == bound; };
    const auto runs = std::ranges::count_if(cells, of);
    const auto broken = std::ranges::count_if(cells, [&](const WhereToBoundCell& c) {
      return of(c) && (c.violations > 0 || c.device_margin < -kWhereToBoundRounding);
    });
    append(text, "%-7s %5td of %td\n", std::string(bound).c_str(), broken, runs);
  }
  return text;
}

}  // namespace feltwire
