#pragma once

#include <string>
#include <string_view>

#include "client/servo_loop.hpp"

namespace feltwire {

/// The line, without what moves a cursor. Round trip: median and 99th percentile of the run; up and
/// down: of the last exchange, with its mean variation (client/clock_estimate.hpp), - before the
/// first; rate and loss: since `before`.
std::string text(const LiveStatus& status, const LiveStatus& before);

/// One line about a run on standard error: rewritten in place on a terminal, one line a second
/// elsewhere.
class StatusLine {
 public:
  StatusLine();
  /// `more` stands at its end.
  void show(const LiveStatus& status, std::string_view more = {});
  /// Leaves the line standing; what is printed next begins a new one.
  void end();

 private:
  bool terminal_;
  bool open_ = false;    // the cursor stands behind an unfinished line
  double shown_ = -1.0;  // [s] time of the last line printed
  LiveStatus before_;
};

}  // namespace feltwire
