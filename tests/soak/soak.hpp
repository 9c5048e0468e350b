#pragma once
// The test: clients come and go for a while; afterwards the checks must hold.

#include <string>
#include <vector>

#include "server/scene/scene_host.hpp"
#include "tests/soak/client.hpp"

namespace feltwire::soak {

struct Options {
  double seconds = 60.0;
  int clients = 100;
  double rate = 1000.0;  // [Hz] of each servo, if the machine is fast enough
  std::uint64_t seed = 1;
  std::string scene_file;
};

struct Check {
  std::string what, measured;
  bool holds = false;
};

struct Outcome {
  Account clients;
  SceneSummary server;
  double rate = 0.0;  // [Hz] that a living client's servo reached
  std::vector<Check> checks;

  bool holds() const {
    for (const Check& check : checks)
      if (!check.holds) return false;
    return true;
  }
};

/// Starts a server, runs the clients, and ends the server. Throws if the server cannot start.
Outcome run(const Options& options);

}  // namespace feltwire::soak
