#include "server/app/summary.hpp"

#include <spdlog/fmt/fmt.h>

#include "core/base/pending_file.hpp"
#include "server/access/json_text.hpp"
#include "server/scene/scene_counters.hpp"

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
  std::vector<Member> members = {{"scene", json_text::text(scene.scene)},
                                 {"sessions", number(std::uint64_t{scene.sessions})}};
  for (const auto& [name, value] : named_counters(scene.counters))
    members.emplace_back(name, number(value));
  members.emplace_back("unsent", number(scene.unsent));
  members.emplace_back("dropped", drops(scene.counters));
  return json_text::object(members);
}

std::string control_json(const ControlSummary& control) {
  std::vector<Member> members;
  for (const auto& [name, value] : named_counters(control.connections, control.requests))
    members.emplace_back(name, number(value));
  return json_text::object(members);
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

std::string text(const ControlSummary& summary) {
  const auto& [connections, requests] = summary;
  return fmt::format(
      "control: connections {} (too often {}, crowded out {}, no TLS {}, too slow {}), "
      "unauthenticated {}, "
      "forbidden {}, too many {}\n",
      connections.accepted, connections.too_often, connections.crowded_out, connections.failed,
      connections.too_slow, requests.unauthenticated, requests.forbidden, requests.too_many);
}

std::string text(const std::vector<SceneSummary>& summary) {
  std::string lines;
  for (const SceneSummary& scene : summary) {
    const SceneCounters& c = scene.counters;
    lines += fmt::format(
        "scene {}: sessions {} (left {}, silent {}, flooded {}, forged {}, disturbing {}, evicted "
        "{}, "
        "failed {}), "
        "samples {}, "
        "replies {} ({} withheld), gaps {} "
        "({} samples missed), unsent {}\n",
        scene.scene, c.sessions_served, c.left, c.silent, c.flooded, c.forged, c.disturbing,
        c.evicted, c.failed, c.samples.samples, c.samples.replies, c.samples.withheld,
        c.samples.gaps, c.samples.missed, scene.unsent);
    std::string drops;
    for (std::size_t i = 1; i < c.drops.size(); ++i)
      if (c.drops[i] > 0)
        drops += fmt::format(" {} {}", name(static_cast<DropReason>(i)), c.drops[i]);
    if (c.world.steps > 0)
      lines += fmt::format(
          "  steps of what moves {} ({} dropped), resets {}, lost bodies {}, warnings {}\n",
          c.world.steps, c.ticks_dropped, c.world.resets, c.world.returned, c.world.warnings);
    lines +=
        fmt::format("  datagrams {}, dropped:{}\n", c.datagrams, drops.empty() ? " none" : drops);
  }
  return lines;
}

}  // namespace feltwire
