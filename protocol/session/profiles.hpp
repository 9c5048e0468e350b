#pragma once
// Named settings for kinds of lines: the amount and rate of traffic. The numbers come from
// docs/lab/trade.md, "The network".

#include <array>
#include <string>
#include <string_view>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

struct NetworkProfile {
  std::string_view name, line;  // its name; its purpose
  double packet_rate = 1000.0;  // [Hz] datagrams each way
  int batch = 1;                // new samples in each, if there are as many
  int redundancy = 3;
  double position_deadband = 0.0, force_deadband = 0.0;  // Weber fractions
  Predictor predictor = Predictor::level;
  double keep_alive = 0.02;  // [s]
  double hold_time = 0.1;    // [s]
  bool local_model = false;
};

inline constexpr std::array<NetworkProfile, 3> kNetworkProfiles = {
    {{.name = "lan", .line = "a cable, or a building's network"},
     {.name = "wan",
      .line = "the internet, some tens of milliseconds away",
      .packet_rate = 100.0,
      .redundancy = 1,
      .force_deadband = 0.05,
      .keep_alive = 0.05,
      .hold_time = 0.25,
      .local_model = true},
     {.name = "thin",
      .line = "64 kbit/s each way",
      .packet_rate = 12.5,  // so that the largest reply may answer every datagram
      .redundancy = 0,
      .force_deadband = 0.1,
      .keep_alive = 0.16,
      .hold_time = 0.8,
      .local_model = true}}};

/// Throws std::invalid_argument that lists the choices if there is no such profile.
const NetworkProfile& network_profile(std::string_view name);
/// The names, for a help text: "lan|wan|thin".
std::string network_profile_names();

/// The parameters of the same session over such a line. Its servo period stays; the side becomes
/// `client` if a local model has to be bounded beside the device.
SessionParameters over(const NetworkProfile& line, SessionParameters parameters);

/// The parameters that a server behind such a line grants: the requested ones, if the line has room
/// for that many datagrams, else over(line, parameters). The hold time is not lengthened if it is
/// five datagrams long; then the keep-alive time is a fifth of it.
SessionParameters granted(const NetworkProfile& line, const SessionParameters& parameters);

}  // namespace feltwire
