#include "server/scene/host_log.hpp"

#include <spdlog/spdlog.h>

#include "core/base/visible_text.hpp"
#include "core/dynamics/world.hpp"

namespace feltwire {

void HostLog::tell_of_sessions(SceneSessions& sessions) {
  tell_of_links(sessions);
  if (sessions.has_answers()) [[unlikely]]
    for (const std::string& line : sessions.answers())
      spdlog::info("scene {}: {}", scene_, visible(line));
  if (sessions.has_short_paths()) [[unlikely]]
    for (const std::string& line : sessions.short_paths())
      spdlog::warn("scene {}: {}", scene_, visible(line));
}

void HostLog::tell_of_links(const SceneSessions& sessions) {
  for (std::size_t seat = 0; seat < kMostSeats; ++seat) {
    const LinkState state =
        seat < sessions.seats() ? sessions.link_state(seat) : LinkState::disabled;
    LinkState& told = told_links_[seat];
    if (state == told) continue;
    const std::string which = sessions.seat_name(seat);
    spdlog::info("scene {}: hand and robot{} are {} (were {})", scene_,
                 which.empty() ? "" : " " + visible(which), name(state), name(told));
    told = state;
  }
}

void HostLog::tell_of_world(const SceneSessions& sessions, Nanoseconds now) {
  const World& world = *sessions.world();
  const WorldNews news{world.counters(), sessions.ticks_dropped(), world.tick()};
  for (const std::string& line : world_log_.lines(news, now))
    spdlog::warn("scene {}: {}", scene_, line);
}

void HostLog::tell_of_load(SceneSessions& sessions, Nanoseconds now) {
  if (sessions.pace().has_line(now)) spdlog::warn("scene {}: {}", scene_, sessions.pace_line(now));
  for (const std::string& line : load_log_.lines(sessions.share().slow(), sessions.shed(), now))
    spdlog::warn("scene {}: {}", scene_, line);
}

void HostLog::tell_of_failure(const std::exception& failure, Nanoseconds now) {
  if (const auto times = failures_.count(1, now))
    spdlog::error(
        "scene {}: the server failed in it: {} ({} times since the last line); its sessions end, "
        "the scene goes on",
        scene_, failure.what(), *times);
}

}  // namespace feltwire
