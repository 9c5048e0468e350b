#pragma once
// What the log says of a scene that its thread cannot keep up with. No clock.

#include <string>
#include <vector>

#include "server/scene/fair_share.hpp"
#include "server/scene/log_limit.hpp"

namespace feltwire {

class LoadLog {
 public:
  /// The lines that are due now, mostly none: of each kind at most one a second, and again only
  /// when it has happened twice as often. `shed`: datagrams of sessions above their share that were
  /// dropped so far.
  std::vector<std::string> lines(const FairShare::Slow& slow, std::uint64_t shed, Nanoseconds now);

 private:
  DoublingLimit slow_lines_, shed_lines_;
};

}  // namespace feltwire
