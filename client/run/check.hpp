#pragma once
// Whether a machine and a network are fit for a session: `feltwire-client --check`.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/run/machine_facts.hpp"
#include "client/run/run_figures.hpp"

namespace feltwire {

enum class Verdict : std::uint8_t {
  pass,
  warn,  // it works, and the hand may feel it now and then
  fail   // forces will be late, faded or missing
};
std::string_view name(Verdict verdict);

struct Finding {
  std::string_view what;  // "rate"
  Verdict verdict = Verdict::pass;
  std::string figure;  // the measured value, with its unit
  std::string remedy;  // empty where it passes
};

/// Judges each of: session, rate, late wake-ups, permissions, processors, clock, answers, round
/// trip, jitter, loss, datagram size. docs/troubleshooting.md has the limits. Without any answer of
/// the server, round trip, jitter and loss are left out.
std::vector<Finding> judge(const RunFigures& run, const MachineFacts& machine);

/// The worst of them; pass if there is none.
Verdict worst(const std::vector<Finding>& findings);
/// A line each, and its remedy below it.
std::string table(const std::vector<Finding>& findings);
/// A JSON list, for the report.
std::string json(const std::vector<Finding>& findings);

}  // namespace feltwire
