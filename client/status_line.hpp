#pragma once

#include "client/servo_loop.hpp"

namespace feltwire {

/// One line about a run on standard error: rewritten in place on a terminal, one line a second
/// elsewhere.
class StatusLine {
 public:
  StatusLine();
  void show(const LiveStatus& status);
  /// Leaves the line standing; what is printed next begins a new one.
  void end();

 private:
  bool terminal_;
  bool open_ = false;    // the cursor stands behind an unfinished line
  double shown_ = -1.0;  // [s] time of the last line printed
  LiveStatus before_;
};

}  // namespace feltwire
