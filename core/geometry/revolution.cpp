#include "core/geometry/revolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace feltwire {

TriangleSoup revolved(const std::vector<Profile>& profile, int segments) {
  TriangleSoup soup;
  const auto n = static_cast<std::uint32_t>(segments);
  const auto rings = static_cast<std::uint32_t>(profile.size() - 2);
  soup.vertices.emplace_back(0.0, 0.0, profile.front().z);
  for (std::uint32_t ring = 1; ring <= rings; ++ring)
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n;
      const Profile& p = profile[ring];
      soup.vertices.emplace_back(p.radius * std::cos(angle), p.radius * std::sin(angle), p.z);
    }
  soup.vertices.emplace_back(0.0, 0.0, profile.back().z);
  const auto last = static_cast<std::uint32_t>(soup.vertices.size() - 1);
  const auto at = [&](std::uint32_t ring, std::uint32_t i) { return 1 + (ring - 1) * n + i % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    soup.triangles.push_back({0, at(1, i), at(1, i + 1)});
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
      soup.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      soup.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
    soup.triangles.push_back({last, at(rings, i + 1), at(rings, i)});
  }
  return soup;
}

std::vector<Profile> capsule_profile(double radius, double half_length, int segments) {
  const int quarter = std::max(1, segments / 4);
  std::vector<Profile> profile;
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i <= quarter; ++i) {
      // The first half has already added the equator.
      if (half == 1 && i == 0 && half_length == 0.0) continue;
      const double angle =
          0.5 * std::numbers::pi * (half + static_cast<double>(i) / quarter);  // [rad] from the top
      profile.push_back({radius * std::sin(angle),
                         radius * std::cos(angle) + (half == 0 ? half_length : -half_length)});
    }
  return profile;
}

}  // namespace feltwire
