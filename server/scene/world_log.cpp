#include "server/scene/world_log.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace feltwire {

std::vector<std::string> WorldLog::lines(const WorldNews& news, Nanoseconds now) {
  constexpr double kMilliseconds = 1e3;  // [ms/s]
  std::vector<std::string> due;
  const WorldCounters& counters = news.counters;
  const std::uint64_t more = counters.resets - std::min(resets_, counters.resets);
  resets_ = counters.resets;
  if (const auto times = reset_lines_.count(more, now))
    due.push_back(
        fmt::format("a step of what moves came to nothing sane; it is back in its last good state, "
                    "at rest ({} times since the last line, {} times so far)",
                    *times, counters.resets));
  if (dropped_lines_.due(news.ticks_dropped, now))
    due.push_back(fmt::format(
        "what moves cannot keep up with time and goes slower: {} ticks of {} ms "
        "dropped so far, of {}; fewer bodies that touch, or a longer tick, would help",
        news.ticks_dropped, kMilliseconds * news.tick, news.ticks_dropped + counters.steps));
  if (warning_lines_.due(counters.warnings, now))
    due.push_back(
        fmt::format("MuJoCo left out contacts that it had no room for, or met a singular inertia "
                    "({} times so far); bodies may pass through each other",
                    counters.warnings));
  return due;
}

void WorldLog::begin_anew() noexcept {
  resets_ = 0;
  warning_lines_.begin_anew();
}

}  // namespace feltwire
