#pragma once
// The way from a run to people: its lines and its state.

#include <string_view>

#include "client/servo/live_status.hpp"

namespace feltwire {

/// All functions are called by the thread that owns the run. They must not throw.
class RunOutlet {
 public:
  virtual ~RunOutlet() = default;
  /// A line about an event: a warning, or a change that an admin made.
  virtual void say(std::string_view line) noexcept = 0;
  /// The state of the run, some times a second, with more text about it.
  virtual void show(const LiveStatus& status, std::string_view more) noexcept = 0;
};

}  // namespace feltwire
