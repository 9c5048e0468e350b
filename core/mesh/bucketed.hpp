#pragma once
// Internal to core/mesh: a sort for entries of corners, which may have a hundred thousand each.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace feltwire {

/// make(0), make(1), ... by their `low`, which is below `lows`, and those of the same by `less`.
template <class Made, class Make, class Less>
std::vector<Made> bucketed(std::size_t count, std::size_t lows, const Make& make,
                           const Less& less) {
  std::vector<std::size_t> first(lows + 1, 0);
  for (std::size_t i = 0; i < count; ++i) ++first[make(i).low + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<Made> all(count);
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Made made = make(i);
    all[next[made.low]++] = made;
  }
  for (std::size_t low = 0; low < lows; ++low)
    std::sort(all.begin() + static_cast<std::ptrdiff_t>(first[low]),
              all.begin() + static_cast<std::ptrdiff_t>(first[low + 1]), less);
  return all;
}

}  // namespace feltwire
