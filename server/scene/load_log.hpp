#pragma once
// Log lines about a scene whose thread cannot keep up. It has no clock.

#include <string>
#include <vector>

#include "server/scene/fair_share.hpp"
#include "server/scene/log_limit.hpp"

namespace feltwire {

class LoadLog {
 public:
  /// The lines that are due now, mostly none: of each kind at most one a second, and again only
  /// when the count has doubled. `shed`: dropped datagrams of sessions above their share so far.
  std::vector<std::string> lines(const FairShare::Slow& slow, std::uint64_t shed, Nanoseconds now);

 private:
  DoublingLimit slow_lines_, shed_lines_;
};

}  // namespace feltwire
