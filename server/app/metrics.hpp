#pragma once
// The counters of a server in the format of Prometheus.

#include <optional>
#include <string>
#include <vector>

#include "core/base/time_counts.hpp"
#include "server/app/server.hpp"
#include "server/web/audience.hpp"

namespace feltwire {

/// The counters of every scene, of the control port and of the live page, in the text exposition
/// format of Prometheus 0.0.4 (docs/live_page.md).
std::string metrics_text(const std::vector<SceneSummary>& scenes, const ControlSummary& control,
                         const web::AudienceCounters& page);
/// The times that a server counted in one of its scenes. Empty: not known.
struct SceneTimes {
  std::string scene;
  std::optional<TimeCounts> answers, world_late;
};
/// Only those of the live page, and times that another server counted.
std::string metrics_text(const web::AudienceCounters& page, const std::vector<SceneTimes>& times);

}  // namespace feltwire
