#include "server/scene/unreachable_objects.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstddef>
#include <vector>

#include "core/scene/broad_phase.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

std::optional<std::string> warning_of_unreachable_objects(const Scene& scene) {
  constexpr std::size_t kShown = 5;
  std::size_t count = 0;
  std::string names;
  for (const Object& object : scene.objects()) {
    const ReachBall ball = reach_ball(object);
    const Vec3 middle = object.pose.position + object.pose.orientation * ball.middle;
    if (!(middle.cwiseAbs().maxCoeff() - ball.radius > kMaxPosition)) continue;
    if (++count <= kShown) names += (count > 1 ? ", '" : "'") + object.name + "'";
  }
  if (count == 0) return std::nullopt;
  if (count > kShown) names += fmt::format(" and {} more", count - kShown);
  return fmt::format(
      "no hand can touch {}: on an axis, places are at most {:g} m from the origin; move the "
      "origin of the scene near its objects, or check the unit",
      names, kMaxPosition);
}

}  // namespace feltwire
