#pragma once
// Whether a machine and a network are fit for a session: `feltwire-client --check`.

#include <vector>

#include "client/run/check_result.hpp"
#include "client/run/machine_facts.hpp"
#include "client/run/run_figures.hpp"

namespace feltwire {

/// Judges each of: session, rate, late wake-ups, permissions, processors, clock, answers, round
/// trip, jitter, loss, datagram size. docs/troubleshooting.md has the limits. Without any answer of
/// the server, round trip, jitter and loss are left out.
std::vector<CheckResult> judge(const RunFigures& run, const MachineFacts& machine);

}  // namespace feltwire
