#include "server/app/summary.hpp"

#include "core/base/pending_file.hpp"
#include "server/access/json_text.hpp"

namespace feltwire {
namespace {

using json_text::Member;
using json_text::number;

std::string drops(const SceneCounters& counters) {
  std::vector<Member> reasons;
  for (std::size_t i = 1; i < counters.drops.size(); ++i)
    reasons.emplace_back(name(static_cast<DropReason>(i)), number(counters.drops[i]));
  return json_text::object(reasons);
}

std::string scene_json(const SceneSummary& scene) {
  const SceneCounters& c = scene.counters;
  return json_text::object({{"scene", json_text::text(scene.scene)},
                            {"sessions", number(std::uint64_t{scene.sessions})},
                            {"sessions_served", number(c.sessions_served)},
                            {"left", number(c.left)},
                            {"silent", number(c.silent)},
                            {"flooded", number(c.flooded)},
                            {"forged", number(c.forged)},
                            {"disturbing", number(c.disturbing)},
                            {"evicted", number(c.evicted)},
                            {"datagrams", number(c.datagrams)},
                            {"late_goodbyes", number(c.late_goodbyes)},
                            {"samples", number(c.samples.samples)},
                            {"replies", number(c.samples.replies)},
                            {"withheld", number(c.samples.withheld)},
                            {"gaps", number(c.samples.gaps)},
                            {"missed", number(c.samples.missed)},
                            {"duplicates", number(c.samples.duplicates)},
                            {"shed", number(c.shed)},
                            {"unsent", number(scene.unsent)},
                            {"dropped", drops(c)}});
}

std::string control_json(const ControlSummary& control) {
  const auto& [connections, requests] = control;
  return json_text::object({{"connections", number(connections.accepted)},
                            {"too_often", number(connections.too_often)},
                            {"crowded_out", number(connections.crowded_out)},
                            {"no_tls", number(connections.failed)},
                            {"too_slow", number(connections.too_slow)},
                            {"unauthenticated", number(requests.unauthenticated)},
                            {"forbidden", number(requests.forbidden)},
                            {"too_many", number(requests.too_many)}});
}

}  // namespace

std::string summary_json(const std::vector<SceneSummary>& summary, const ControlSummary& control) {
  std::vector<std::string> scenes;
  scenes.reserve(summary.size());
  for (const SceneSummary& scene : summary) scenes.push_back(scene_json(scene));
  return json_text::object(
             {{"scenes", json_text::list(scenes)}, {"control", control_json(control)}}) +
         "\n";
}

void write_summary(const std::filesystem::path& file, const std::vector<SceneSummary>& summary,
                   const ControlSummary& control) {
  replace_file(file, summary_json(summary, control), kByUmask);
}

}  // namespace feltwire
