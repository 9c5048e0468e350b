#include "sim/replay/replay_report.hpp"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

double speed(const Replay& replay, double took) { return took > 0.0 ? replay.time / took : 0.0; }

}  // namespace

std::string verdict(const Replay& replay) {
  if (replay.difference) {
    const ReplayDifference& at = *replay.difference;
    std::string where = fmt::format("different at {:.6f} s, event {}", at.time, at.event);
    if (at.hand != 0) where += fmt::format(", hand {}", at.hand);
    if (at.sample != 0) where += fmt::format(", sample {}", at.sample);
    return where + ": " + at.what;
  }
  if (replay.lost > 0)
    return fmt::format("not complete: {} events are missing after event {}; bit-equal up to there",
                       replay.lost, replay.events);
  return "bit-equal";
}

std::string replay_text(const Replay& replay, double took) {
  std::string text = fmt::format(
      "scene {}: {:.3f} s, {} sessions, {} events, {} replies, {} ticks of what moves; computed in "
      "{:.3f} s ({:.0f} times as fast)\n",
      replay.scene, replay.time, replay.sessions, replay.events, replay.replies, replay.ticks, took,
      speed(replay, took));
  if (replay.cut_at)
    text += fmt::format("the file was cut at byte {}: its last seconds may be missing\n",
                        *replay.cut_at);
  if (replay.recorded_by != replay.replayed_by)
    text += "recorded by another build, which may compute other last bits: " + replay.recorded_by +
            "\nreplayed by: " + replay.replayed_by + "\n";
  return visible_lines(text + verdict(replay) + "\n");
}

std::string replay_json(const Replay& replay, double took) {
  nlohmann::ordered_json json = {{"scene", replay.scene},
                                 {"bit_equal", replay.bit_equal()},
                                 {"verdict", verdict(replay)},
                                 {"time", replay.time},
                                 {"took", took},
                                 {"speed", speed(replay, took)},
                                 {"sessions", replay.sessions},
                                 {"events", replay.events},
                                 {"replies", replay.replies},
                                 {"ticks", replay.ticks},
                                 {"lost", replay.lost},
                                 {"recorded_by", replay.recorded_by},
                                 {"replayed_by", replay.replayed_by}};
  if (replay.cut_at) json["cut_at"] = *replay.cut_at;
  if (replay.difference)
    json["difference"] = {{"event", replay.difference->event},
                          {"time", replay.difference->time},
                          {"hand", replay.difference->hand},
                          {"sample", replay.difference->sample},
                          {"what", replay.difference->what}};
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  return json.dump(2, ' ', false, kReplace) + "\n";
}

}  // namespace feltwire
