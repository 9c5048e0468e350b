#include "server/scene/load_log.hpp"

#include <spdlog/fmt/fmt.h>

namespace feltwire {

std::vector<std::string> LoadLog::lines(const FairShare::Slow& slow, std::uint64_t shed,
                                        Nanoseconds now) {
  constexpr double kMilliseconds = 1e3;  // [ms/s]
  std::vector<std::string> due;
  if (slow_lines_.due(slow.seconds, now))
    due.push_back(fmt::format(
        "an answer takes {:.3g} ms on average, and a session's datagrams are {:.3g} ms apart: its "
        "forces come late and some samples are not answered ({} times so far); a simpler scene or "
        "a longer servo period would help",
        kMilliseconds * slow.answer, kMilliseconds * slow.interval, slow.seconds));
  if (shed_lines_.due(shed, now))
    due.push_back(
        fmt::format("the scene's thread is short of time: {} datagrams of sessions that use more "
                    "than their share of it were dropped so far",
                    shed));
  return due;
}

}  // namespace feltwire
