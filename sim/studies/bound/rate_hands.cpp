#include <algorithm>

#include "core/base/text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/rate.hpp"

namespace feltwire {

void write_rate_hands(const std::filesystem::path& directory, const std::vector<RateCell>& cells) {
  std::string text =
      "surface,hand,damping,rate_hz,displayed_n_per_m,direction_error_deg,oscillation_um\n";
  for (const RateCell& c : cells)
    append(text, "%s,%s,%g,%g,%.6g,%.6g,%.6g\n", c.surface.c_str(), std::string(c.hand).c_str(),
           c.damping, c.rate, c.displayed, c.direction_error * kDegrees, c.oscillation * 1e6);
  write_text(directory / "rate_hands.csv", text);
}

std::string rate_hands_table(const std::vector<RateCell>& cells) {
  constexpr std::size_t kHands = kEightHands.size();
  std::string text =
      "\nIn double by eight hands: the median of the hands and the worst\n"
      "               b       rate   displayed [N/m]   direction error [deg]  oscillation [um]\n"
      "surface        [Ns/m]  [kHz]   median    worst     median      worst    median    worst\n";
  for (std::size_t i = 0; i + kHands <= cells.size(); i += kHands) {
    const RateCell& cell = cells[i];
    std::vector<double> displayed, direction, oscillation;
    for (std::size_t hand = 0; hand < kHands; ++hand) {
      displayed.push_back(cells[i + hand].displayed);
      direction.push_back(cells[i + hand].direction_error * kDegrees);
      oscillation.push_back(cells[i + hand].oscillation * 1e6);
    }
    if (i > 0 && (cells[i - 1].surface != cell.surface || cells[i - 1].damping != cell.damping))
      text += '\n';
    append(text, "%-13s  %6.1f  %5.2f %8.0f %8.0f %10.3f %10.3f  %8.2f %8.2f\n",
           cell.surface.c_str(), cell.damping, cell.rate / 1e3, median(displayed),
           std::ranges::min(displayed), median(direction), std::ranges::max(direction),
           median(oscillation), std::ranges::max(oscillation));
  }
  return text;
}

}  // namespace feltwire
