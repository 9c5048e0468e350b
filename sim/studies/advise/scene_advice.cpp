#include "sim/studies/advise/scene_advice.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "core/scene/mechanism.hpp"
#include "sim/studies/advise/cost_prediction.hpp"

namespace feltwire::advise {
namespace {

constexpr std::size_t kTravels = 200'000;  // triangles that a client fetches (docs/network.md)
constexpr double kTickShare = 0.5;         // of a core that moving bodies may take

void add_geometry(const SceneFacts& facts, std::vector<std::string>& lines) {
  const auto line = [&](const char* format, auto... values) {
    std::string text;
    append(text, format, values...);
    lines.push_back(text);
  };
  if (facts.meshes == 0 && facts.grids == 0)
    line("geometry: keep the primitives; no other shape is as exact or as cheap");
  if (facts.meshes > 0 && facts.triangles <= kTravels)
    line("geometry: keep the meshes; their %zu triangles travel to the client whole",
         facts.triangles);
  if (facts.triangles > kTravels)
    line(
        "geometry: reduce the meshes to %zu triangles together (%zu now), so that they travel to "
        "the client whole",
        kTravels, facts.triangles);
  if (facts.meshes_beyond_travel > 0)
    line(
        "geometry: %zu mesh(es) stay patches at the client, because they move or have a height "
        "map",
        facts.meshes_beyond_travel);
  if (facts.grids > 0)
    line(
        "geometry: a grid needs a step of a fifth of the smallest radius that must feel round; "
        "grids and meshes hold %.1f MB now",
        1e-6 * static_cast<double>(facts.geometry_bytes));
}

void add_tool(const SceneFacts& facts, std::vector<std::string>& lines) {
  constexpr std::size_t kUsualPoints = 10'000, kPointsForMany = 3'000;
  if (facts.polygons)
    lines.emplace_back("tool: keep the polygons; they are the most exact for pegs, edges and keys");
  else if (facts.points > kUsualPoints)
    lines.push_back("tool: 10000 points are enough at 1 kHz; it has " +
                    std::to_string(facts.points));
  else if (facts.points > kPointsForMany)
    lines.emplace_back("tool: 3000 points cost a third, where several hands share a core");
}

void add_tick(const SceneFacts& facts, std::vector<std::string>& lines) {
  if (facts.moving == 0) return;
  const double needed = tick_time(facts.moving);
  const double least = std::max(kLeastTick, needed / kTickShare);
  const double tick = std::min(kLargestTick, std::max(kDefaultTick, least));
  std::string text;
  append(
      text,
      "MuJoCo tick: %.2f ms (%.2f ms now); a tick of %zu bodies at rest takes some %.0f us, %.0f "
      "%% of a core",
      kMilli * tick, kMilli * facts.tick, facts.moving, kMicro * needed, kPercent * needed / tick);
  if (needed / kLargestTick > kTickShare)
    text += "; that is more than a core has: use fewer bodies, or joints in place of contacts";
  lines.push_back(text);
}

}  // namespace

std::vector<std::string> scene_advice(const SceneFacts& facts) {
  std::vector<std::string> lines;
  add_geometry(facts, lines);
  add_tool(facts, lines);
  add_tick(facts, lines);
  return lines;
}

}  // namespace feltwire::advise
