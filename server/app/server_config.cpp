#include "server/app/server_config.hpp"

#include <array>
#include <asio/ip/address.hpp>
#include <charconv>
#include <functional>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "core/base/json_document.hpp"
#include "core/recording/recording_files.hpp"
#include "protocol/net/busy_poll.hpp"
#include "protocol/net/link_local.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/session/profiles.hpp"
#include "protocol/wire/control.hpp"
#include "server/app/server_config_generated.h"
#include "server/app/server_config_text.hpp"

namespace feltwire {
namespace {

constexpr int kLastPort = 65535;
constexpr int kMostSessions = 4096;
constexpr int kMostWebHands = 64;  // largest --web-hands; each hand has its own threads
constexpr double kLeastSampleRate = 1.1, kLargestSampleRate = 1e6;  // ratios to the servo rate
// Value of busy_poll in a configuration file for threads that never sleep.
constexpr double kNeverSleeps = -1.0;
constexpr std::array<const char*, 6> kLogLevels = {"trace",   "debug", "info",
                                                   "warning", "error", "off"};

/// An error in the value of an option, with the names of the option in the configuration file and
/// on the command line.
struct Complaint {
  const char* field;   // name in the configuration file
  const char* option;  // name on the command line
  std::string message;
};

std::optional<Complaint> out_of_range(const char* field, const char* option, double value,
                                      double least, double most) {
  if (value >= least && value <= most) return std::nullopt;
  std::ostringstream text;
  text << value << " is not within " << least << " to " << most;
  return Complaint{field, option, text.str()};
}

std::optional<Complaint> security_complaint(const ServerConfig& c) {
  constexpr double kShortest = 0.01, kLongest = 3600.0;  // [s] limits of timeouts and intervals
  constexpr int kMostConnections = 10'000;
  constexpr double kFastest = 1e6;  // [1/s] largest rate; also the largest burst
  if (c.certificate.empty() != c.key.empty())
    return Complaint{"certificate", "--certificate",
                     "a certificate and its key go together; give both, or neither"};
  if (auto wrong = out_of_range("max_sessions_per_client", "--max-sessions-per-client",
                                c.max_sessions_per_client, 1, kMostSessions))
    return wrong;
  if (auto wrong = out_of_range("join_rate", "--join-rate", c.join_rate, 1.0 / kLongest, kFastest))
    return wrong;
  if (auto wrong = out_of_range("join_burst", "--join-burst", c.join_burst, 1, kFastest))
    return wrong;
  if (auto wrong = out_of_range("handshake_timeout", "--handshake-timeout", c.handshake_timeout,
                                kShortest, kLongest))
    return wrong;
  if (auto wrong =
          out_of_range("idle_timeout", "--idle-timeout", c.idle_timeout, kShortest, kLongest))
    return wrong;
  if (auto wrong = out_of_range("max_connections", "--max-connections", c.max_connections, 2,
                                kMostConnections))
    return wrong;
  if (auto wrong = out_of_range("max_connections_per_network", "--max-connections-per-network",
                                c.max_connections_per_network, 1, kMostConnections))
    return wrong;
  if (auto wrong = out_of_range("handshake_rate", "--handshake-rate", c.handshake_rate,
                                1.0 / kLongest, kFastest))
    return wrong;
  return out_of_range("handshake_burst", "--handshake-burst", c.handshake_burst, 1, kFastest);
}

std::optional<Complaint> recording_complaint(const ServerConfig& c) {
  if (!c.record.empty() && !is_mcap(c.record))
    return Complaint{"record", "--record",
                     "'" + c.record.string() + "' is no MCAP file's name; write FILE.mcap"};
  if (!(c.record_max_mib >= 1.0))
    return Complaint{"record_max_mib", "--record-max-mib",
                     std::to_string(c.record_max_mib) + " MiB is too little; give 1 or more"};
  if (!(c.record_max_seconds >= 1.0))
    return Complaint{"record_max_seconds", "--record-max-seconds",
                     std::to_string(c.record_max_seconds) + " s is too little; give 1 or more"};
  return std::nullopt;
}

std::optional<Complaint> complaint(const ServerConfig& c) {
  const int scenes = static_cast<int>(c.scenes.size());
  if (scenes > static_cast<int>(control::kMaxScenes))
    return Complaint{"scenes", "--scene",
                     std::to_string(scenes) + " scenes are too many; one server has at most " +
                         std::to_string(control::kMaxScenes)};
  std::error_code bad_address;
  const auto address = asio::ip::make_address(c.address, bad_address);
  if (bad_address)
    return Complaint{"address", "--address",
                     "'" + c.address +
                         "' is no IP address; 127.0.0.1 serves this machine, :: "
                         "every network, 0.0.0.0 those of IPv4"};
  if (auto wrong = missing_zone(address))
    return Complaint{"address", "--address", *std::move(wrong)};
  // Each scene has its own port. These ports follow the control port.
  if (c.port < 0 || c.port + (c.port == 0 ? 0 : scenes) > kLastPort)
    return Complaint{"port", "--port",
                     std::to_string(c.port) + " is not within 1 to " +
                         std::to_string(kLastPort - scenes) + " (" + std::to_string(scenes) +
                         " scene ports follow it), nor 0 for a free place for all"};
  if (!(c.silence_timeout >= control::kShortestSilence &&
        c.silence_timeout <= control::kLongestSilence))
    return Complaint{"silence_timeout", "--silence-timeout",
                     std::to_string(c.silence_timeout) + " s is not within 0.1 to 3600 s"};
  if (c.max_sessions_per_scene < 1 || c.max_sessions_per_scene > kMostSessions)
    return Complaint{"max_sessions_per_scene", "max_sessions_per_scene",
                     std::to_string(c.max_sessions_per_scene) + " is not within 1 to " +
                         std::to_string(kMostSessions)};
  if (!(c.sample_rate_limit >= kLeastSampleRate && c.sample_rate_limit <= kLargestSampleRate))
    return Complaint{"sample_rate_limit", "sample_rate_limit",
                     std::to_string(c.sample_rate_limit) +
                         " times the servo rate is not within 1.1 to 1000000; clocks differ, so 1 "
                         "would be too little"};
  if (auto wrong = security_complaint(c)) return wrong;
  if (!c.profile.empty()) {
    try {
      network_profile(c.profile);
    } catch (const std::invalid_argument& unknown) {
      return Complaint{"profile", "--profile", unknown.what()};
    }
  }
  if (!possible_busy_poll(c.busy_poll))
    return Complaint{
        "busy_poll", "--busy-poll",
        std::to_string(c.busy_poll) +
            " us is not within 0 to 1000000 us; a thread that never sleeps is inf, in a "
            "file -1"};
  try {
    dscp(c.dscp);
  } catch (const std::invalid_argument& wrong) {
    return Complaint{"dscp", "--dscp", wrong.what()};
  }
  if (!c.web.empty()) {
    try {
      web_place(c.web);
    } catch (const std::invalid_argument& wrong) {
      return Complaint{"web", "--web", wrong.what()};
    }
  }
  if (auto wrong = recording_complaint(c)) return wrong;
  if (auto wrong = out_of_range("web_hands", "--web-hands", c.web_hands, 0, kMostWebHands))
    return wrong;
  if (find_named(kLogLevels, c.log_level) == nullptr)
    return Complaint{"log_level", "--log-level",
                     "'" + c.log_level + "' is none of " + joined_names(kLogLevels, ", ")};
  return std::nullopt;
}

}  // namespace

ServerConfig load_config(const std::filesystem::path& file) {
  return parse_config(read_text(file), file);
}

ServerConfig parse_config(std::string_view json, const std::filesystem::path& file) {
  const JsonDocument document(json, file.string(), embedded::server_config);
  const auto* root = flatbuffers::GetRoot<config_file::Server>(document.buffer());
  ServerConfig config;
  if (root->scenes() != nullptr) {
    flatbuffers::uoffset_t i = 0;
    for (const auto* scene : *root->scenes()) {
      if (scene->size() == 0)
        document.fail("scenes[" + std::to_string(i) + "]", "is empty; name a scene file");
      config.scenes.push_back(file.parent_path() / scene->str());
      ++i;
    }
  }
  if (root->address() != nullptr) config.address = root->address()->str();
  config.port = root->port();
  config.silence_timeout = root->silence_timeout();
  config.max_sessions_per_scene = root->max_sessions_per_scene();
  config.sample_rate_limit = root->sample_rate_limit();
  const auto path = [&](const flatbuffers::String* text) {
    return text == nullptr ? std::filesystem::path() : file.parent_path() / text->str();
  };
  config.state = path(root->state());
  config.certificate = path(root->certificate());
  config.key = path(root->key());
  config.client_ca = path(root->client_ca());
  config.tokens = path(root->tokens());
  config.max_sessions_per_client = root->max_sessions_per_client();
  config.join_rate = root->join_rate();
  config.join_burst = root->join_burst();
  config.handshake_timeout = root->handshake_timeout();
  config.idle_timeout = root->idle_timeout();
  config.max_connections = root->max_connections();
  config.max_connections_per_network = root->max_connections_per_network();
  config.handshake_rate = root->handshake_rate();
  config.handshake_burst = root->handshake_burst();
  if (root->profile() != nullptr) config.profile = root->profile()->str();
  // A file has -1 in place of infinity, because JSON has no infinity.
  config.busy_poll = root->busy_poll() == kNeverSleeps ? HUGE_VAL : root->busy_poll();
  config.real_time = root->real_time();
  if (root->dscp() != nullptr) config.dscp = root->dscp()->str();
  if (root->web() != nullptr) config.web = root->web()->str();
  if (root->web_names() != nullptr)
    for (const auto* name : *root->web_names()) config.web_names.push_back(name->str());
  config.record = path(root->record());
  // In a file, 0 or a negative number means no limit.
  if (root->record_max_mib() > 0.0) config.record_max_mib = root->record_max_mib();
  if (root->record_max_seconds() > 0.0) config.record_max_seconds = root->record_max_seconds();
  config.flight_recorder = path(root->flight_recorder());
  config.web_hands = root->web_hands();
  if (root->log_level() != nullptr) config.log_level = root->log_level()->str();
  if (const auto wrong = complaint(config)) document.fail(wrong->field, wrong->message);
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

void validate(const ServerConfig& config) {
  if (config.scenes.empty())
    throw std::invalid_argument(
        "no scene to serve; name one with --scene FILE or in the configuration file");
  if (const auto wrong = complaint(config))
    throw std::invalid_argument(std::string(wrong->option) + ": " + wrong->message);
}

}  // namespace feltwire
