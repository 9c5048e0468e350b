#include "server/scene/scene_counters.hpp"

#include <string>

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
          {"shed", c.shed},
          {"slowed", c.slowed}};
}

control::Counters counter_list(const SceneCounters& counters) {
  control::Counters list;
  for (const auto& [counter, value] : named_counters(counters))
    list.counters.push_back({std::string(counter), value});
  for (std::size_t i = 1; i < counters.drops.size(); ++i)
    list.counters.push_back(
        {std::string("dropped.") + name(static_cast<DropReason>(i)), counters.drops[i]});
  return list;
}

}  // namespace feltwire
