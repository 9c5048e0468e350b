#include "core/dynamics/neighbour_list.hpp"

#include <algorithm>
#include <cmath>

#include "core/scene/broad_phase.hpp"

namespace feltwire {
namespace {

/// Returns the margin [m] of the neighbour list: the median radius. A wider margin keeps a list
/// valid for longer, but makes the list longer. If equal objects are side by side, this margin adds
/// about ten objects to the list.
double margin_of(std::vector<double> radii) {
  std::erase_if(radii, [](double r) { return !std::isfinite(r); });
  if (radii.empty()) return 0.0;
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

}  // namespace

NeighbourSearch::NeighbourSearch(std::span<const Object> moving, double tool_radius) {
  std::vector<double> radii;
  for (const Object& object : moving) {
    const ReachBall ball = reach_ball(object);
    radii.push_back(ball.radius + tool_radius);
    middles_.push_back(ball.middle);
  }
  margin_ = margin_of(radii);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    // Share of the margin that allows for rounding errors over weeks.
    constexpr double kRounding = 1e-9;
    const double wide = radii[i] + (1.0 + kRounding) * margin_;
    balls_.push_back({Vec3::Zero(), radii[i] * radii[i], wide * wide});
    place(i, moving[i].pose);
  }
  begin_anew();
}

void NeighbourSearch::place(std::size_t i, const Pose& pose) noexcept {
  const Vec3 center = pose.position + pose.orientation * middles_[i];
  largest_ = std::max(largest_, (center - balls_[i].center).squaredNorm());
  balls_[i].center = center;
}

void NeighbourSearch::placed() noexcept {
  drift_ += std::sqrt(largest_);
  largest_ = 0.0;
}

}  // namespace feltwire
