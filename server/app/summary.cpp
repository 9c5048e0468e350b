#include "server/app/summary.hpp"

#include "core/base/pending_file.hpp"
#include "server/access/json_text.hpp"
#include "server/scene/named_counters.hpp"

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

}  // namespace feltwire
