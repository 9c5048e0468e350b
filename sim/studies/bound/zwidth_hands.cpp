#include <algorithm>

#include "core/base/text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/zwidth.hpp"

namespace feltwire {
namespace {

/// Results over all hands for one method, damping, rate and delay. A hand is calm if it does not
/// oscillate.
struct LoopHands {
  double largest = 0.0, least_largest = 0.0;  // [N/m] largest calm stiffness: median, worst
  double shown = 0.0, least_shown = 0.0;      // [N/m] displayed at 5 kN/m: median, worst
  std::size_t calm = 0, hands = 0;            // number of calm hands at 5 kN/m, of all hands
};

LoopHands over_hands(const ZWidthCell* first, std::size_t hands) {
  std::vector<double> largest, shown;
  LoopHands loop{.hands = hands};
  for (const ZWidthCell* cell = first; cell != first + hands; ++cell) {
    largest.push_back(cell->limit.stiffness);
    shown.push_back(cell->at_fixed.displayed.value_or(0.0));
    loop.calm += cell->at_fixed.calm() ? 1 : 0;
  }
  loop.largest = median(largest);
  loop.least_largest = std::ranges::min(largest);
  loop.shown = median(shown);
  loop.least_shown = std::ranges::min(shown);
  return loop;
}

/// Returns the stiffness in kN/m as text, or "any" at the end of the searched range.
std::string kilo(double stiffness) {
  if (stiffness >= StiffnessRange{}.highest) return "any";
  std::string text;
  append(text, "%.3g", stiffness / 1e3);
  return text;
}

}  // namespace

void write_zwidth_hands(const std::filesystem::path& directory,
                        const std::vector<ZWidthCell>& cells) {
  std::string text =
      "method,hand,damping,rate_hz,delay_ms,max_stiffness,above_range,displayed_at_5k,"
      "oscillation_at_5k_um\n";
  for (const ZWidthCell& c : cells)
    append(text, "%s,%s,%g,%g,%g,%.6g,%d,%.6g,%.4g\n", std::string(c.method).c_str(),
           std::string(c.hand).c_str(), c.damping, c.rate, c.delay * 1e3, c.limit.stiffness,
           c.limit.above_range ? 1 : 0, c.at_fixed.displayed.value_or(0.0),
           c.at_fixed.oscillation * 1e6);
  write_text(directory / "zwidth_hands.csv", text);
}

std::string zwidth_hands_table(const std::vector<ZWidthCell>& cells) {
  constexpr std::size_t kHands = kEightHands.size();
  std::string text =
      "\nBy eight hands at 1 kHz [kN/m]: the median of the hands / the worst. max: the largest "
      "commanded without\noscillation (any: the whole range). at 5: what is met of 5 kN/m, 0 by a "
      "hand that "
      "oscillates; and how many are calm.\n";
  std::string last;
  for (std::size_t i = 0; i + kHands <= cells.size(); i += kHands) {
    const ZWidthCell& c = cells[i];
    if (i == 0) {
      append(text, "%34s", "");
      for (std::size_t n = i;
           n < cells.size() && cells[n].damping == c.damping && cells[n].method == c.method;
           n += kHands)
        append(text, " | %29g ms", cells[n].delay * 1e3);
      append(text, "\n%-29s %4s", "method", "b");
      for (std::size_t n = i;
           n < cells.size() && cells[n].damping == c.damping && cells[n].method == c.method;
           n += kHands)
        text += " |            max           at 5 calm";
    }
    std::string head;
    append(head, "\n%-29s %4g", std::string(c.method).c_str(), c.damping);
    if (head != last) text += head;
    last = head;
    const LoopHands o = over_hands(&c, kHands);
    append(text, " | %6s /%6s %6s /%6s %zu/%zu", kilo(o.largest).c_str(),
           kilo(o.least_largest).c_str(), kilo(o.shown).c_str(), kilo(o.least_shown).c_str(),
           o.calm, o.hands);
  }
  return text + '\n';
}

}  // namespace feltwire
