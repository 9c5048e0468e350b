#include "sim/studies/teleop/lost_contact.hpp"

#include <algorithm>

namespace feltwire::teleop {
namespace {

/// Returns for how long [s] the hand feels a force after the robot loses the surface. The robot
/// loses contact at sample `lost` and regains contact at sample `again`. Returns nothing if the
/// samples do not show the loss.
std::optional<double> release(const std::vector<BenchSample>& samples, std::size_t lost,
                              std::size_t again, std::size_t end, double period) {
  const double place = samples[lost].surface;
  std::size_t since = end, n = lost;  // first sample of the counted time; `end`: none yet
  // The hand feels the next contact half a round trip later, so the search goes on to `end`.
  for (; n < end && samples[n + 1].held >= LostContact::kFree; ++n)
    if (n < again && samples[n].robot < place)
      since = end;
    else if (since == end)
      since = n;
  if (since == end) return std::nullopt;
  const bool free = n < end;
  const double alone = period * static_cast<double>(again - std::min(again, since));
  if (!free && alone <= LostContact::kReacts) return std::nullopt;
  return period * static_cast<double>(n - since);
}

}  // namespace

std::optional<LostContact> lost_contact(const std::vector<BenchSample>& samples, std::size_t first,
                                        std::size_t last, std::size_t late, double period) {
  const auto touches = [&](std::size_t n) { return samples[n].contact > 0.0; };
  std::size_t without = 0, felt = 0;
  double longest = 0.0;
  for (std::size_t n = first; n < last; ++n) {
    if (touches(n)) continue;
    ++without;
    if (samples[n + 1].held > LostContact::kFelt) ++felt;
    if (n == first || !touches(n - 1)) continue;
    std::size_t again = n;
    while (again < last && !touches(again)) ++again;
    const auto time = release(samples, n, again, std::min(again + late, last), period);
    longest = std::max(longest, time.value_or(0.0));
  }
  if (without == 0) return std::nullopt;
  return LostContact{.felt = static_cast<double>(felt) / static_cast<double>(without),
                     .release = std::max(0.0, longest - period * static_cast<double>(late))};
}

}  // namespace feltwire::teleop
