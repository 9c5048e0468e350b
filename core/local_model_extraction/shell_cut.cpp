#include "core/local_model_extraction/shell_cut.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feltwire {
namespace {

constexpr std::size_t kMostNumbered = std::numeric_limits<std::uint16_t>::max();

/// Splits a part into two parts. Returns false if that is impossible.
bool halves(const ShellPart& part, ShellPart& low, ShellPart& high) {
  ShellPart whole = part;
  while (!whole.of_points && whole.end - whole.begin == 1) {
    const ShellNode& node = whole.shell->nodes[whole.begin];
    whole.of_points = node.children == 0;
    whole.begin = whole.of_points ? node.begin : node.child;
    whole.end = whole.of_points ? node.end : node.child + node.children;
  }
  if (whole.end - whole.begin < 2) return false;
  low = high = whole;
  low.end = high.begin = whole.begin + (whole.end - whole.begin + 1) / 2;
  return true;
}

}  // namespace

double ShellPart::coarseness() const {
  if (single()) return 0.0;
  const double far = std::clamp(nearest() / kBodyReach, 0.0, 1.0);
  return radius * std::pow(1.0 - far, 4);
}

ShellCut::ShellCut(const PointShell& shell, const std::vector<Object>& objects,
                   const KnownSurfaces& known, const Pose& tool, int most)
    : most_(most),
      shell_(shell),
      objects_(objects),
      tool_(tool),
      turned_(tool.orientation.toRotationMatrix()) {
  if (std::ranges::count(known, true) == std::ssize(objects_)) reach_ = kModelReach;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if ((i < known.size() && known[i]) || !may_be_near(i)) continue;
    const auto side = [&](const PointShell& one) {
      const ShellPart root{.object = i, .shell = &one, .begin = 0, .end = 1};
      if (i <= kMostNumbered)
        offer(root);
      else
        miss(root);
    };
    std::ranges::for_each(shell_.sides, side);
    if (shell_.sides.empty()) side(shell_);
  }
  while (refine()) {
  }
}

FieldPoint ShellCut::at(std::size_t object, const Vec3& arm) const {
  const Object& o = objects_[object];
  const Quaternion to_object = o.pose.orientation.conjugate();
  FieldPoint field = signed_distance(
      o.shape, o.felt_from, to_object * (tool_.position + turned_ * arm - o.pose.position));
  field.gradient = o.pose.orientation * field.gradient;
  return field;
}

std::pair<std::uint32_t, std::uint32_t> ShellCut::points_of(const ShellPart& part) const {
  if (part.of_points) return {part.begin, part.end};
  return {part.shell->nodes[part.begin].begin, part.shell->nodes[part.end - 1].end};
}

/// Returns true if a point of the shell may be within reach_ of an object. This test excludes most
/// objects.
bool ShellCut::may_be_near(std::size_t object) const {
  const ShellNode& whole = shell_.nodes.front();
  return at(object, whole.center).distance - whole.radius < reach_;
}

void ShellCut::miss(ShellPart part) {
  measure(part);
  reach_ = std::min(reach_, part.nearest());
}

/// Computes the bounding ball of a part and the distance of its centre from the surface.
void ShellCut::measure(ShellPart& part) const {
  const auto n = static_cast<double>(part.end - part.begin);
  part.center.setZero();
  part.radius = 0.0;
  for (std::uint32_t i = part.begin; i < part.end; ++i)
    part.center += (part.of_points ? part.shell->points[i] : part.shell->nodes[i].center) / n;
  for (std::uint32_t i = part.begin; i < part.end; ++i) {
    const double reaches = part.of_points ? (part.shell->points[i] - part.center).norm()
                                          : (part.shell->nodes[i].center - part.center).norm() +
                                                part.shell->nodes[i].radius;
    part.radius = std::max(part.radius, reaches);
  }
  part.distance = at(part.object, part.center).distance;
}

/// Adds a part if it is within reach_, the distance within which the model is complete. If there
/// are too many parts, the farthest part is dropped and limits this distance.
void ShellCut::offer(ShellPart part) {
  measure(part);
  if (!(part.nearest() < reach_)) return;
  if (count_ == most_) {
    const auto end = parts_.begin() + count_;
    const auto farthest = std::max_element(
        parts_.begin(), end,
        [](const ShellPart& a, const ShellPart& b) { return a.nearest() < b.nearest(); });
    if (farthest->nearest() < part.nearest()) {
      reach_ = std::min(reach_, part.nearest());
      return;
    }
    reach_ = std::min(reach_, farthest->nearest());
    *farthest = part;
    return;
  }
  parts_[static_cast<std::size_t>(count_++)] = part;
}

/// Splits the coarsest part in two. Returns false if no part may be split.
bool ShellCut::refine() {
  constexpr double kFine = 1e-5;  // [m] A part with a smaller coarseness is not split.
  const auto begin = parts_.begin(), end = begin + count_;
  const auto coarsest = std::max_element(begin, end, [](const ShellPart& a, const ShellPart& b) {
    return a.coarseness() < b.coarseness();
  });
  if (coarsest == end || !(coarsest->coarseness() > kFine)) return false;
  ShellPart low, high;
  if (!halves(*coarsest, low, high)) return false;
  measure(low);
  measure(high);
  const bool keeps_low = low.nearest() < reach_, keeps_high = high.nearest() < reach_;
  if (keeps_low && keeps_high && count_ == most_) return false;
  *coarsest = keeps_low ? low : high;
  if (keeps_low && keeps_high) parts_[static_cast<std::size_t>(count_++)] = high;
  if (!keeps_low && !keeps_high) *coarsest = parts_[static_cast<std::size_t>(--count_)];
  return true;
}

}  // namespace feltwire
