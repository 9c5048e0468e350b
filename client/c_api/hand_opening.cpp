#include "client/c_api/hand_opening.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "client/app/open_client.hpp"
#include "client/c_api/caller_device.hpp"
#include "client/servo/device_input.hpp"
#include "core/base/written_number.hpp"
#include "core/device/device_file.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {
namespace {

[[noreturn]] void refuse(const HandRequest& request, const std::string& what) {
  throw std::invalid_argument(std::string(request.options) + "." + what);
}

/// Throws std::invalid_argument for an option that has no meaning in a library.
void require_meaning(const HandRequest& request, const std::string& word) {
  constexpr std::array kOfTheProgram = {"--help",  "--help-all", "--version",  "--list",
                                        "--check", "--report",   "--rehearsal"};
  for (const char* option : kOfTheProgram)
    if (word == option || word.starts_with(std::string(option) + "="))
      refuse(request, "more: " + word + " is for feltwire-client only");
}

constexpr std::string_view kCaller = "caller", kStepped = "stepped";

/// How the program is the device itself: it moves the hand while the servo ticks, or it makes the
/// ticks too. Empty: another device.
std::string_view kind_of_program(const HandRequest& request) {
  const std::string_view asked(request.device == nullptr ? "" : request.device);
  for (const std::string_view kind : {kCaller, kStepped})
    if (asked.substr(0, asked.find(':')) == kind) return kind;
  return {};
}

/// Returns the words of feltwire-client for this request. `kind`: of kind_of_program().
std::vector<std::string> command_line(const HandRequest& request, std::string_view kind) {
  std::vector<std::string> words = request.place;
  const auto add = [&](const char* option, const char* value) {
    if (value != nullptr) words.insert(words.end(), {option, value});
  };
  add("--name", request.name);
  // A person may hold what the program moves: the limits are those of a plugin.
  std::string device(request.device == nullptr ? "" : request.device);
  if (!kind.empty()) {
    const std::size_t colon = device.find(':');
    const std::string settings = colon == std::string::npos ? "" : device.substr(colon + 1);
    device = "plugin:" + std::string(kind) + (settings.empty() ? "" : "," + settings);
  }
  add("--device", request.device == nullptr ? nullptr : device.c_str());
  add("--spec", request.spec);
  add("--duration", shortest_text(request.duration).c_str());
  if (request.more_count > 0 && request.more == nullptr)
    refuse(request, "more is null, and more_count is not 0");
  for (std::uint32_t i = 0; i < request.more_count; ++i) {
    if (request.more[i] == nullptr) refuse(request, "more has a null word");
    require_meaning(request, request.more[i]);
    words.emplace_back(request.more[i]);
  }
  const auto is_recorder = [](const std::string& word) {
    return word.starts_with("--flight-recorder");
  };
  if (std::ranges::none_of(words, is_recorder)) add("--flight-recorder", "off");
  return words;
}

/// Throws std::invalid_argument for an option that has no meaning without a server.
void require_no_server(const HandRequest& request, const std::vector<std::string>& words) {
  constexpr std::array kOfAServer = {"--connect",     "--fingerprint", "--fingerprint-file",
                                     "--ca",          "--cert",        "--key",
                                     "--token-file",  "--scene",       "--role",
                                     "--local-model", "--link",        "--reconnect"};
  for (const std::string& word : words)
    for (const std::string option : kOfAServer)
      if (word == option || word.starts_with(option + "="))
        refuse(request, "more: " + option + " needs a server: leave it out");
}

/// A hand that a person may hold has an energy account behind its law, as no call may get a force
/// past it. Throws std::invalid_argument for a law without one.
void require_account(const HandRequest& request, const ClientOptions& options) {
  if (!options.driver->held_by_person) return;
  const char* why =
      " leaves the hand without an energy account, and a person may hold this device; "
      "give another law, or the device simulated, which nobody holds";
  if (options.parameters.mode == kUnbounded)
    refuse(request, std::string("more: --mode none") + why);
  if (!options.servo.account) refuse(request, std::string("more: account=off of --mode") + why);
}

/// The options of these words. A program that is the device is a plugin there, and its `kind` in an
/// error.
ClientOptions options_of_hand(const std::vector<std::string>& words, std::string_view kind,
                              bool has_server) {
  try {
    return options_of(words, has_server);
  } catch (const std::invalid_argument& error) {
    constexpr std::string_view kPlugin = "--device plugin:";
    std::string said = error.what();
    if (const std::size_t at = said.find(kPlugin); !kind.empty() && at != std::string::npos)
      said.replace(at, kPlugin.size(), "device " + std::string(kind) + ":");
    throw std::invalid_argument(said);
  }
}

std::unique_ptr<CallerDevice> caller_device(const HandRequest& request, std::string_view kind,
                                            ClientOptions& options) {
  const double longest = kDevicePatience * options.parameters.hold_time;
  if (!(request.stale_after >= 1e-3 && request.stale_after < longest))
    refuse(request, "stale_after must be from 0.001 s to less than a quarter of the hold time, " +
                        std::to_string(longest) +
                        " s; move the hand more often, or give a longer --hold-time");
  if (options.device.name != kind)
    refuse(request, "device: " + std::string(request.device) +
                        " has more than settings; write it as " + std::string(kind) +
                        ":map_scale=2, and --help-all of feltwire-client lists the settings");
  options.device_kind = kind;
  options.takes = {};  // a person may hold what the program moves
  return std::make_unique<CallerDevice>(requested_spec(options.device.spec, "simulated").spec,
                                        request.stale_after,
                                        kind == kStepped ? options.parameters.servo_period : 0.0);
}

}  // namespace

std::unique_ptr<OpenHand> open_hand(const HandRequest& request, const SimulatorScene* simulator) {
  const std::string_view kind = kind_of_program(request);
  const std::vector<std::string> words = command_line(request, kind);
  if (simulator != nullptr) require_no_server(request, words);
  ClientOptions options = options_of_hand(words, kind, simulator == nullptr);
  require_account(request, options);
  options.rehearses = false;  // it prints
  std::shared_ptr<SimulatorFeed> feed;
  options.hooks.open_port = port_opener(options);
  if (simulator != nullptr) feed = meet_simulator(options, *simulator);
  OpenedDevice opened;
  CallerDevice* caller = nullptr;
  if (!kind.empty()) {
    auto device = caller_device(request, kind, options);
    caller = device.get();
    opened.device = std::move(device);
  } else {
    opened = options.driver->open(options.device);
  }
  const std::vector<std::string> notes = std::move(opened.notes);
  auto device = hand_device(std::move(opened), options);
  auto hand = std::make_unique<OpenHand>(std::move(options), std::move(device), caller, feed);
  for (const std::string& note : notes) hand->messages().keep("note: " + note);
  return hand;
}

}  // namespace feltwire
