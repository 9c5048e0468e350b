#pragma once
// The counters of a server as Prometheus reads them.

#include <string>
#include <vector>

#include "server/app/server.hpp"
#include "server/web/audience.hpp"

namespace feltwire {

/// The counters of every scene, of the control port and of the live page, in the text exposition
/// format of Prometheus 0.0.4 (docs/live_page.md).
std::string metrics_text(const std::vector<SceneSummary>& scenes, const ControlSummary& control,
                         const web::AudienceCounters& page);
/// Those of the live page alone.
std::string metrics_text(const web::AudienceCounters& page);

}  // namespace feltwire
