#pragma once
// Tells people at a terminal what happens in a run.

#include "client/run/run_outlet.hpp"
#include "client/run/status_line.hpp"

namespace feltwire {

/// Writes to standard error, each line with the name of the program.
class TerminalOutlet final : public RunOutlet {
 public:
  void say(std::string_view line) noexcept override;
  void show(const LiveStatus& status, std::string_view more) noexcept override;
  /// Leaves the status line; later output begins a new one.
  void end_line() noexcept { line_.end(); }

 private:
  StatusLine line_;
};

}  // namespace feltwire
