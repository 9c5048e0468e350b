#include "server/scene/named_counters.hpp"

namespace feltwire {

std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(const SceneCounters& c) {
  return {{"sessions_served", c.sessions_served},
          {"left", c.left},
          {"silent", c.silent},
          {"flooded", c.flooded},
          {"forged", c.forged},
          {"disturbing", c.disturbing},
          {"evicted", c.evicted},
          {"failed", c.failed},
          {"datagrams", c.datagrams},
          {"late_goodbyes", c.late_goodbyes},
          {"samples", c.samples.samples},
          {"replies", c.samples.replies},
          {"withheld", c.samples.withheld},
          {"gaps", c.samples.gaps},
          {"missed", c.samples.missed},
          {"duplicates", c.samples.duplicates},
          {"late_ticks", c.samples.late_ticks},
          {"shed", c.shed}};
}

}  // namespace feltwire
