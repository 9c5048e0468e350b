#include "client/follower_app/follower_report.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "client/run/link_states_json.hpp"
#include "core/build_info/build_info.hpp"

namespace feltwire {
namespace {

std::string_view name(FollowerEnd end) {
  constexpr std::array<std::string_view, 3> kNames = {"requested", "lost", "evicted"};
  return kNames.at(static_cast<std::size_t>(end));
}

/// Returns "; the robot failed at 2.0 s: ..." if it was faulty at the end; else an empty text.
std::string robot_fault_text(const FollowerResult& result) {
  if (!result.robot_failed()) return {};
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(),
                "; the robot failed at %.1f s: it gave no usable state any more; see its driver",
                std::max(0.0, result.duration - result.faulty_for));
  return text.data();
}

}  // namespace

std::string report_json(const FollowerSpec& robot, const FollowerRun& run,
                        const FollowerResult& result) {
  const FollowerStatistics& s = result.statistics;
  const nlohmann::ordered_json report = {
      {"name", run.name},
      {"scene", run.scene},
      {"server", to_string(run.server.endpoint)},
      {"feltwire", {{"version", version()}, {"compiler", compiler()}, {"build", build_type()}}},
      {"robot",
       {{"name", robot.name},
        {"servo_period_s", robot.servo_period},
        {"stiffness_n_per_m", robot.stiffness},
        {"damping_n_s_per_m", robot.damping},
        {"own_damping_n_s_per_m", robot.own_damping},
        {"mass_kg", robot.mass},
        {"senses_wrench", robot.senses_wrench},
        {"wrench_noise_n", robot.wrench_noise}}},
      {"end", name(result.end)},
      {"sessions", result.sessions},
      {"samples", s.samples},
      {"late_samples", result.overruns},
      {"targets", s.targets},
      {"targets_stale", s.targets_stale},
      {"engagements", s.engagements},
      {"holds", s.holds},
      {"faulty_readings", s.faults},
      {"largest_force_n", s.largest_force},
      {"link", link_states_json(s.link_states)}};
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string report_line(const FollowerResult& result) {
  const FollowerStatistics& s = result.statistics;
  std::array<char, 32> force{};
  std::snprintf(force.data(), force.size(), "%.2f", s.largest_force);
  return "samples " + std::to_string(s.samples) + " (" + std::to_string(result.overruns) +
         " late), targets " + std::to_string(s.targets) + ", engaged " +
         std::to_string(s.engagements) + " times, largest force " + force.data() + " N, sessions " +
         std::to_string(result.sessions) + ", end: " + std::string(name(result.end)) +
         robot_fault_text(result);
}

}  // namespace feltwire
