#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/studies/fleet/fleet_scenarios.hpp"

namespace feltwire::fleet {
namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;
/// A value in a host's memory: its bytes decoded, its key, and the node of a map. Assumption; a
/// record's texts lie in the record itself if they are short.
constexpr std::size_t kNode = 64;

std::string text(const char* format, auto... values) {
  std::string line(256, '\0');
  line.resize(static_cast<std::size_t>(std::snprintf(line.data(), line.size(), format, values...)));
  return line;
}

double heartbeat_bytes(const FleetStudy& study) {  // [1/s] to the directory and to all hosts
  return study.hosts / study.inputs.heartbeat * static_cast<double>(study.heartbeat) *
         (3.0 + study.hosts);
}

double directory_memory(const FleetStudy& study) {  // [bytes] of each server
  return static_cast<double>(study.inputs.scenes) *
             static_cast<double>(study.scene_record + kNode) +
         static_cast<double>(study.hosts) * static_cast<double>(study.heartbeat + kNode);
}

double host_memory(const FleetStudy& study) {  // [bytes] of what each host knows of all scenes
  return static_cast<double>(study.inputs.scenes) * (sizeof(SceneOwnership) + kNode) +
         static_cast<double>(study.hosts) *
             (sizeof(HostRecord) + static_cast<double>(study.heartbeat) + kNode);
}

}  // namespace

std::string fleet_table(const FleetStudy& study) {
  std::string table = text(
      "%u scenes with %u hands: %u hosts of %u cores (%u hold all, with none to lose); the\n"
      "fullest is loaded by %.0f %%\n",
      study.inputs.scenes, study.hands, study.hosts, study.inputs.cores, study.least_hosts,
      100.0 * study.load);
  table += text(
      "directory: a scene takes %zu bytes, a heartbeat %zu; heartbeats %.0f a second, %.1f "
      "MiB/s with\nall watches; memory %.1f MiB in each server, %.1f MiB in each host\n\n",
      study.scene_record, study.heartbeat, study.hosts / study.inputs.heartbeat,
      heartbeat_bytes(study) / kMebibyte, directory_memory(study) / kMebibyte,
      host_memory(study) / kMebibyte);
  table += text("%-33s %8s %7s %7s %9s %8s %7s %8s %10s\n", "", "hands", "median", "max s",
                "joins/s", "takeover", "moves", "writes", "peak MiB/s");
  for (const FleetRun& run : study.runs) {
    const FleetCounts& counts = run.counts;
    table += text("%-33s %8u %7.2f %7.1f %9.0f %8llu %7llu %8llu %10.2f\n", run.name.c_str(),
                  run.hands, counts.without_session.quantile(0.5) / kMicroseconds,
                  static_cast<double>(counts.without_session.max()) / kMicroseconds,
                  counts.joins_by_second.peak(), static_cast<unsigned long long>(counts.takeovers),
                  static_cast<unsigned long long>(counts.moves),
                  static_cast<unsigned long long>(counts.writes),
                  counts.bytes_by_second.peak() / kMebibyte);
  }
  table += '\n';
  for (const FleetRun& run : study.runs) {
    table += text("%s: %s after %.1f s", run.name.c_str(),
                  run.finished ? "all is well again" : "NOT finished", run.rebalanced);
    table += text("; %llu sessions of a former owner were refused",
                  static_cast<unsigned long long>(run.counts.lower_epochs));
    for (const auto& [what, value] : run.notes) table += "; " + what + " " + value;
    table += '\n';
  }
  return table;
}

void write_fleet(const std::filesystem::path& folder, const FleetStudy& study) {
  nlohmann::ordered_json json = {{"scenes", study.inputs.scenes},
                                 {"hands", study.hands},
                                 {"hosts", study.hosts},
                                 {"least_hosts", study.least_hosts},
                                 {"cores", study.inputs.cores},
                                 {"scene_record_bytes", study.scene_record},
                                 {"heartbeat_bytes", study.heartbeat},
                                 {"heartbeat_bytes_per_second", heartbeat_bytes(study)},
                                 {"directory_bytes", directory_memory(study)},
                                 {"host_bytes", host_memory(study)},
                                 {"runs", nlohmann::ordered_json::array()}};
  for (const FleetRun& run : study.runs) {
    const FleetCounts& counts = run.counts;
    nlohmann::ordered_json entry = {
        {"name", run.name},
        {"finished", run.finished},
        {"hands", run.hands},
        {"rebalanced_s", run.rebalanced},
        {"last_hand_s", run.last_hand},
        {"without_session_p50_s", counts.without_session.quantile(0.5) / kMicroseconds},
        {"without_session_p99_s", counts.without_session.quantile(0.99) / kMicroseconds},
        {"attempts", counts.attempts},
        {"crowded_out", counts.crowded_out},
        {"peak_joins_per_second", counts.joins_by_second.peak()},
        {"takeovers", counts.takeovers},
        {"moves", counts.moves},
        {"directory_writes", counts.writes},
        {"directory_bytes", counts.bytes},
        {"directory_peak_bytes_per_second", counts.bytes_by_second.peak()},
        {"lower_epochs_refused", counts.lower_epochs}};
    for (const auto& [what, value] : run.notes) entry["notes"][what] = value;
    json["runs"].push_back(entry);
  }
  std::filesystem::create_directories(folder);
  const auto file = folder / "fleet.json";
  std::ofstream out(file);
  out << json.dump(2) << '\n';
  out.flush();
  if (!out) throw std::runtime_error("cannot write " + file.string() + "; is the disk full?");
}

}  // namespace feltwire::fleet
