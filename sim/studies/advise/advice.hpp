#pragma once
// The advice: settings for a device, a link and a scene, and what they will give.

#include <optional>
#include <string>
#include <vector>

#include "client/emulated_link/link_options.hpp"
#include "sim/studies/advise/cost_prediction.hpp"
#include "sim/studies/advise/feel_prediction.hpp"

namespace feltwire::advise {

struct Question {
  DeviceSpec device;
  TwoWayLinkOptions link;
  int hands = 1;              // in the scene at once
  int cores = 1;              // of the server
  double most_rate = 4000.0;  // [Hz] of the servo
  bool explains = true;       // finds limits and gains of the walls, which takes most of the time
};

/// Throws std::invalid_argument that names the option and the remedy: no hand, no core, a rate that
/// is not possible, a device whose numbers are not possible.
void validate(const Question& question);

/// A predicted number with its error band.
struct Predicted {
  double value = 0.0, low = 0.0, high = 0.0;
};

struct Advice {
  Setting setting;
  std::vector<std::string> reasons = {};  // of the setting, a sentence each
  std::vector<Felt> feel = {};            // in the order of SceneFacts::materials
  Predicted oscillation{};                // [m] RMS at rest
  Predicted force_delay{};                // [s] of the force beyond the hand's own movement
  Predicted news_age{};                   // [s] of what the client knows of the scene
  double link_delay = 0.0;                // [s] of it the link's own round trip
  Predicted up{}, down{};                 // [kbit/s] of one hand, headers included
  Predicted server{}, client{};           // [s] of computing for a second, without system calls
  Predicted hands_a_core{};
  Predicted server_memory{}, session_memory{}, client_memory{};  // [bytes]
  Cost cost{};
  double fade = 1.0;                    // share of a command that the link leaves, in the mean
  Limit limit = Limit::nothing;         // what limits the session beside the materials
  std::vector<std::string> remedies{};  // what more of it would give
  std::vector<std::string> scene{};     // geometry, MuJoCo tick
  int cores_needed = 1;
};

/// `places`: where the scene is touched, for the size of the local model and the cost of contact.
Advice advise(const Question& question, const Scene& scene, const std::vector<Place>& places,
              const std::optional<MachineSpeed>& machine = {});

/// The place where a hand starts in a scene that it does not know.
std::vector<Place> start_places(const Scene& scene);

}  // namespace feltwire::advise
