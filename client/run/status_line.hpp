#pragma once

#include <string>
#include <string_view>

#include "client/servo/servo_loop.hpp"

namespace feltwire {

/// The line, without cursor movements. Round trip: median and 99th percentile of the run; up and
/// down: of the last exchange, with its mean variation (client/servo/clock_estimate.hpp), - before
/// the first; rate and loss: since `before`.
std::string text(const LiveStatus& status, const LiveStatus& before);

/// " (no force: the hand touches nothing)" for the last line of a run without any force; else
/// empty.
std::string no_force_text(const ServoStatistics& statistics);
/// ", oscillation 3.1 um, displayed stiffness 487 N/m": the measured ones of the two.
std::string feel_text(const FeelMetrics& measures);
/// ", contact cut off in 12 ticks"; empty if it was in none.
std::string cut_text(const ServoStatistics& statistics);

/// The line about a run on standard error: rewritten in place on a terminal, printed once a second
/// elsewhere.
class StatusLine {
 public:
  StatusLine();
  /// `more` is added at its end.
  void show(const LiveStatus& status, std::string_view more = {});
  /// Leaves the line; later output begins a new one.
  void end();

 private:
  bool terminal_;
  bool open_ = false;    // the cursor is after an unfinished line
  double shown_ = -1.0;  // [s] time of the last line printed
  LiveStatus before_;
};

}  // namespace feltwire
