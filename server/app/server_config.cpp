#include "server/app/server_config.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <asio/ip/address.hpp>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/base/enum_names.hpp"
#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/recording/recording_files.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/net/busy_poll.hpp"
#include "protocol/net/link_local.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/session/profiles.hpp"
#include "protocol/wire/control.hpp"
#include "server/app/config_options.hpp"
#include "server/app/fleet_settings.hpp"
#include "server/scene/slow_down.hpp"
#include "server/web/authority.hpp"

namespace feltwire {
namespace {

constexpr int kLastPort = 65535;
constexpr int kMostSessions = 4096;
constexpr int kMostWebHands = 64;  // largest --web-hands; each hand has its own threads
constexpr double kLeastSampleRate = 1.1, kLargestSampleRate = 1e6;  // ratios to the servo rate
constexpr std::array<const char*, 2> kLogFormats = {"text", "json"};
constexpr std::array<const char*, 6> kLogLevels = {"trace",   "debug", "info",
                                                   "warning", "error", "off"};

/// The error of a value, beginning with its option: "--port: ...". Nothing: it is right.
using Complaint = std::optional<std::string>;

Complaint complaint_of(const char* option, const std::string& message) {
  return std::string(option) + ": " + message;
}

Complaint range_complaint(const ServerConfig& c) {
  constexpr double kShortest = 0.01, kLongest = 3600.0;  // [s] limits of timeouts and intervals
  constexpr double kFastest = 1e6;  // [1/s] largest rate; also the largest burst
  constexpr int kMostConnections = 10'000;
  struct Range {
    const char* option;
    double value, least, most;
  };
  for (const Range& range : std::initializer_list<Range>{
           {"--silence-timeout", c.silence_timeout, control::kShortestSilence,
            control::kLongestSilence},
           {"--max-sessions-per-scene", 1.0 * c.max_sessions_per_scene, 1, kMostSessions},
           {"--sample-rate-limit", c.sample_rate_limit, kLeastSampleRate, kLargestSampleRate},
           {"--max-sessions-per-client", 1.0 * c.max_sessions_per_client, 1, kMostSessions},
           {"--join-rate", c.join_rate, 1.0 / kLongest, kFastest},
           {"--join-burst", c.join_burst, 1, kFastest},
           {"--handshake-timeout", c.connections.handshake_timeout, kShortest, kLongest},
           {"--idle-timeout", c.connections.idle_timeout, kShortest, kLongest},
           {"--max-connections", 1.0 * c.connections.max, 2, kMostConnections},
           {"--max-connections-per-network", 1.0 * c.connections.max_per_network, 1,
            kMostConnections},
           {"--handshake-rate", c.connections.handshake_rate, 1.0 / kLongest, kFastest},
           {"--handshake-burst", c.connections.handshake_burst, 1, kFastest},
           {"--web-hands", 1.0 * c.web_hands, 0, kMostWebHands}}) {
    if (range.value >= range.least && range.value <= range.most) continue;
    std::ostringstream text;
    text << range.value << " is not within " << range.least << " to " << range.most;
    return complaint_of(range.option, text.str());
  }
  return {};
}

Complaint recording_complaint(const ServerConfig& c) {
  if (!c.recording.file.empty() && !is_mcap(c.recording.file))
    return complaint_of(
        "--record", "'" + c.recording.file.string() + "' is no MCAP file's name; write FILE.mcap");
  if (!(c.recording.max_mib >= 1.0))
    return complaint_of("--record-max-mib",
                        std::to_string(c.recording.max_mib) + " MiB is too little; give 1 or more");
  if (!(c.recording.max_seconds >= 1.0))
    return complaint_of("--record-max-seconds", std::to_string(c.recording.max_seconds) +
                                                    " s is too little; give 1 or more");
  return {};
}

Complaint complaint(const ServerConfig& c) {
  const int scenes = static_cast<int>(c.scenes.size());
  if (scenes > static_cast<int>(control::kMaxScenes))
    return complaint_of("--scene", std::to_string(scenes) +
                                       " scenes are too many; one server has at most " +
                                       std::to_string(control::kMaxScenes));
  std::error_code bad_address;
  const auto address = asio::ip::make_address(c.address, bad_address);
  if (bad_address)
    return complaint_of("--address", "'" + c.address +
                                         "' is no IP address; 127.0.0.1 serves this machine, :: "
                                         "every network, 0.0.0.0 those of IPv4");
  if (auto wrong = missing_zone(address)) return complaint_of("--address", *std::move(wrong));
  // The scenes share a port. If they cannot (server/scene/scene_ports.hpp), each has its own. They
  // follow the control port.
  if (c.port < 0 || c.port + (c.port == 0 ? 0 : scenes) > kLastPort)
    return complaint_of("--port", std::to_string(c.port) + " is not within 1 to " +
                                      std::to_string(kLastPort - scenes) + " (" +
                                      std::to_string(scenes) +
                                      " scene ports follow it), nor 0 for a free place for all");
  if (c.certificate.empty() != c.key.empty())
    return complaint_of("--certificate",
                        "a certificate and its key go together; give both, or neither");
  if (auto wrong = range_complaint(c)) return wrong;
  if (!c.profile.empty()) {
    try {
      network_profile(c.profile);
    } catch (const std::invalid_argument& unknown) {
      return complaint_of("--profile", unknown.what());
    }
  }
  if (!possible_busy_poll(c.busy_poll))
    return complaint_of(
        "--busy-poll",
        std::to_string(c.busy_poll) +
            " us is not within 0 to 1000000 us; a thread that never sleeps is inf, in a "
            "file -1");
  try {
    dscp(c.dscp);
  } catch (const std::invalid_argument& wrong) {
    return complaint_of("--dscp", wrong.what());
  }
  try {
    slow_down_order(c.slow_down);
  } catch (const std::invalid_argument& wrong) {
    return complaint_of("--slow-down", "'" + c.slow_down + "' " + wrong.what());
  }
  for (const auto& [option, place] : {std::pair("--web", &c.web), {"--metrics", &c.metrics}}) {
    try {
      if (!place->empty()) web_place(*place);
    } catch (const std::invalid_argument& wrong) {
      return complaint_of(option, wrong.what());
    }
  }
  if (auto wrong = wrong_web_name(c.web_names))
    return complaint_of("--web-name", *std::move(wrong));
  if (auto wrong = recording_complaint(c)) return wrong;
  try {
    if (!c.fleet.empty()) fleet_settings(c);
  } catch (const std::invalid_argument& wrong) {
    return wrong.what();
  }
  if (find_named(kLogFormats, c.log.format) == nullptr)
    return complaint_of("--log-format",
                        "'" + c.log.format + "' is none of " + joined_names(kLogFormats, ", "));
  if (find_named(kLogLevels, c.log.level) == nullptr)
    return complaint_of("--log-level",
                        "'" + c.log.level + "' is none of " + joined_names(kLogLevels, ", "));
  return {};
}

}  // namespace

ServerConfig load_config(const std::filesystem::path& file) {
  try {
    return parse_config(read_text(file), file);
  } catch (const FileError& error) {
    throw std::invalid_argument(error.what());
  }
}

ServerConfig parse_config(std::string_view json, const std::filesystem::path& file) {
  CLI::App app;
  ServerConfig config;
  add_config_options(app, config);
  const char* const program = "feltwire-server";
  const ConfigFile read = read_config(app, json, file, {}, server_file_value);
  try {
    parse_words(app, words_with_config(app, 1, &program, read, {}, false));
  } catch (const CLI::ParseError& error) {
    throw FileError(read.located(error.what()));
  }
  if (const auto wrong = complaint(config)) throw FileError(read.located(*wrong));
  return config;
}

WebPlace web_place(std::string_view text) {
  const std::string said = "'" + std::string(text) + "' ";
  const auto colon = text.rfind(':');
  WebPlace place;
  std::string_view port = text;
  if (colon != std::string_view::npos) {
    std::string_view address = text.substr(0, colon);
    port = text.substr(colon + 1);
    const bool bracketed = address.starts_with('[') && address.ends_with(']');
    if (bracketed) address = address.substr(1, address.size() - 2);
    place.address = address;
    std::error_code bad_address;
    const auto parsed = asio::ip::make_address(place.address, bad_address);
    if (bad_address || parsed.is_v6() != bracketed)
      throw std::invalid_argument(said +
                                  "has no IP address before its port; write 6760, 0.0.0.0:6760 or "
                                  "[::]:6760");
  }
  const auto end = std::from_chars(port.data(), port.data() + port.size(), place.port);
  if (end.ec != std::errc() || end.ptr != port.data() + port.size())
    throw std::invalid_argument(said +
                                "has no port of 0 to 65535; write 6760, or 0 for a free one");
  return place;
}

std::string config_error(const ServerConfig& config) { return complaint(config).value_or(""); }

std::optional<std::string> wrong_web_name(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!web::parse_authority(name))
      return "'" + name + "' is no host name; write it alone, as lab.example, without https://";
  return std::nullopt;
}

void validate(const ServerConfig& config) {
  if (config.scenes.empty())
    throw std::invalid_argument(
        "no scene to serve; name one with --scene FILE or in the configuration file");
  if (config.demo && (!config.tokens.empty() || !config.client_ca.empty()))
    throw std::invalid_argument(
        "--demo: its hands have a token of the state folder and no certificate; leave --tokens and "
        "--client-ca out");
  if (const auto wrong = complaint(config)) throw std::invalid_argument(*wrong);
  if (config.demo &&
      2 * config.scenes.size() > static_cast<std::size_t>(config.max_sessions_per_client))
    throw std::invalid_argument(
        "--demo: its two hands in each of " + std::to_string(config.scenes.size()) +
        " scenes are of one client, which may have --max-sessions-per-client " +
        std::to_string(config.max_sessions_per_client) +
        " sessions; raise it, or serve fewer scenes");
}

}  // namespace feltwire
