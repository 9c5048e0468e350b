#pragma once
// The settings in --mode METHOD,storage=elastic and in --traffic PROFILE,packet_rate=100, and the
// session parameters that follow from them.

#include <CLI/CLI.hpp>

#include "client/app/option_values.hpp"
#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// Adds the settings of --mode to `keys`. They are written to `values` and `options`.
void add_mode_settings(CLI::App& keys, OptionValues& values, ClientOptions& options);
/// Adds the settings of --traffic to `keys`. They are written to `values` and `parameters`.
void add_traffic_settings(CLI::App& keys, OptionValues& values, SessionParameters& parameters);

/// Reads the settings of values.mode.method, which keeps the method or nothing. Throws
/// std::invalid_argument.
void read_mode_settings(CLI::App& keys, OptionValues& values);
/// Reads values.traffic.words: `parameters` become those of its profile, and its settings override
/// them. Call it after read_mode_settings(). Throws std::invalid_argument.
void read_traffic_settings(CLI::App& keys, OptionValues& values, SessionParameters& parameters);

/// The period of the servo [s] at --rate. Throws std::invalid_argument.
double servo_period_of(const OptionValues& values);
/// Sets the bounding method, its side, the account and the local model. The values that are not
/// given follow from the others. Throws std::invalid_argument.
void choose_bound(const OptionValues& values, ClientOptions& options);
/// Sets the datagram rate and the deadbands. Throws std::invalid_argument.
void choose_traffic(const OptionValues& values, Role role, SessionParameters& parameters);

/// The options of earlier versions that are settings of --mode and --traffic now, and those of the
/// local model.
Renamed renamed_session_options(const CLI::App& mode, const CLI::App& traffic);

}  // namespace feltwire
