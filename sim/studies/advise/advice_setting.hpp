#pragma once
// The settings of a session between which the advice chooses.

#include <string>
#include <vector>

#include "core/bounding/bounding_config.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire::advise {

struct Setting {
  std::string law = "shaped";  // a method of the registry
  Storage storage = Storage::minimal;
  double rate = 1000.0;         // [Hz] of the servo
  std::string profile = "wan";  // a network profile
  bool force_deadband = true;   // as the profile has it; false: every datagram is answered
  bool local_model = true;

  /// Throws std::invalid_argument for a name that does not exist.
  SessionParameters parameters() const;
  /// The value of --mode and of --traffic.
  std::string mode_option() const;
  std::string traffic_option() const;
  friend bool operator==(const Setting&, const Setting&) = default;
};

/// The laws and servo rates, those first that are preferred where two feel alike. `most_rate` [Hz].
std::vector<Setting> law_choices(double most_rate);
/// The traffic for one law and rate, with a local model, the preferred ones first.
std::vector<Setting> traffic_choices(const Setting& law, bool moving);

}  // namespace feltwire::advise
