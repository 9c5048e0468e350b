#include "server/summary.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace feltwire {
namespace {

using Json = nlohmann::ordered_json;

Json drops(const SceneCounters& counters) {
  Json reasons = Json::object();
  for (std::size_t i = 1; i < counters.drops.size(); ++i)
    reasons[name(static_cast<DropReason>(i))] = counters.drops[i];
  return reasons;
}

Json scene_json(const SceneSummary& scene) {
  const SceneCounters& c = scene.counters;
  return {{"scene", scene.scene},
          {"sessions", scene.sessions},
          {"sessions_served", c.sessions_served},
          {"left", c.left},
          {"silent", c.silent},
          {"flooded", c.flooded},
          {"forged", c.forged},
          {"evicted", c.evicted},
          {"datagrams", c.datagrams},
          {"late_goodbyes", c.late_goodbyes},
          {"samples", c.samples.samples},
          {"replies", c.samples.replies},
          {"withheld", c.samples.withheld},
          {"gaps", c.samples.gaps},
          {"missed", c.samples.missed},
          {"duplicates", c.samples.duplicates},
          {"unsent", scene.unsent},
          {"dropped", drops(c)}};
}

Json control_json(const ControlSummary& control) {
  const auto& [connections, requests] = control;
  return {{"connections", connections.accepted},    {"too_often", connections.too_often},
          {"crowded_out", connections.crowded_out}, {"no_tls", connections.failed},
          {"too_slow", connections.too_slow},       {"unauthenticated", requests.unauthenticated},
          {"forbidden", requests.forbidden},        {"too_many", requests.too_many}};
}

}  // namespace

std::string summary_json(const std::vector<SceneSummary>& summary, const ControlSummary& control) {
  Json scenes = Json::array();
  for (const SceneSummary& scene : summary) scenes.push_back(scene_json(scene));
  return Json{{"scenes", scenes}, {"control", control_json(control)}}.dump(
             2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

void write_summary(const std::filesystem::path& file, const std::vector<SceneSummary>& summary,
                   const ControlSummary& control) {
  const std::filesystem::path part = file.string() + ".part";
  std::ofstream out(part, std::ios::trunc);
  out << summary_json(summary, control);
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(part, file, error);
  if (!out || error)
    throw std::runtime_error("cannot write " + file.string() +
                             "; is its folder there, and may this user write to it?");
}

}  // namespace feltwire
