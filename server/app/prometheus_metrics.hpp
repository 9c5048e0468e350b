#pragma once
// The counters of a server in the format of Prometheus.

#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/control.hpp"
#include "server/app/server.hpp"
#include "server/web/viewer_hub.hpp"

namespace feltwire {

/// The counters of every scene, of the control port and of the live page, in the text exposition
/// format of Prometheus 0.0.4 (docs/live_page.md).
std::string metrics_text(const std::vector<SceneSummary>& scenes, const ControlSummary& control,
                         const web::ViewerHubCounters& page);
/// The times of a scene, and its name.
using NamedTimes = std::pair<std::string, control::SceneTimes>;
/// Only those of the live page, and times that another server counted.
std::string metrics_text(const web::ViewerHubCounters& page, const std::vector<NamedTimes>& times);

}  // namespace feltwire
