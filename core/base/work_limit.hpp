#pragma once
// A limit of the cost of queries. The cost is counted in the things that a query looks at and not
// in time, so that the same query ends at the same place on every machine.

#include <cstdint>
#include <limits>

namespace feltwire {

/// Counts the work of queries against a limit. A unit is about what a tree's node, a triangle or
/// two points of a body cost: some 25 ns. A query that is cut off leaves its memory as it was, and
/// its result means nothing. Queries take a pointer; null: no limit.
class WorkLimit {
 public:
  static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

  explicit WorkLimit(std::uint64_t most) noexcept : most_(most), left_(most) {}

  /// False: more is asked for than is left. Then nothing is left from now on.
  bool take(std::uint64_t units) noexcept {
    if (units <= left_) {
      left_ -= units;
      return true;
    }
    left_ = 0;
    cut_ = true;
    return false;
  }
  /// Some query asked for more than was left.
  bool cut() const noexcept { return cut_; }
  std::uint64_t done() const noexcept { return most_ - left_; }
  std::uint64_t left() const noexcept { return left_; }

 private:
  std::uint64_t most_, left_;
  bool cut_ = false;
};

/// Whether a query may go on, at this cost.
inline bool may_go_on(WorkLimit* work, std::uint64_t units = 1) noexcept {
  return work == nullptr || work->take(units);
}
inline bool is_cut(const WorkLimit* work) noexcept { return work != nullptr && work->cut(); }

}  // namespace feltwire
