#pragma once
// The settings of an emulated link, from text or a profile. docs/link.md explains each to the user.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "client/emulated_link/link_trace.hpp"

namespace feltwire {

/// The distribution of a delay about its mean. All three have the same standard deviation.
enum class Jitter : std::uint8_t { normal, uniform, pareto };
inline constexpr std::array<std::string_view, 3> kJitterNames = {"normal", "uniform", "pareto"};

/// A direction of a link. With all zero, every datagram passes at once.
struct LinkOptions {
  double delay = 0.0;   // [s] mean
  double jitter = 0.0;  // [s] standard deviation
  Jitter distribution = Jitter::normal;
  bool keep_order = true;       // no datagram overtakes another, except by `reorder`
  double loss = 0.0;            // share of datagrams lost on the way, 0 to 1
  double burst = 0.0;           // [datagrams] mean run of losses, >= 1; 0: losses are independent
  double reorder = 0.0;         // share that others overtake, 0 to 1
  double reorder_delay = 5e-3;  // [s] delay of these
  double duplicate = 0.0;       // share that arrives twice, 0 to 1
  double rate = 0.0;            // [bit/s] of the slowest line; 0: no limit
  double queue = 64e3;          // [bytes] of the queue in front of that line
  std::shared_ptr<const LinkTrace> trace;  // delay and loss, in place of those above; may be null
};

/// Both directions. The same seed gives the same fate to the same datagrams.
struct TwoWayLinkOptions {
  std::string text;  // as given
  std::uint64_t seed = 1;
  LinkOptions up, down;  // client to server, and back
};

/// Throws std::invalid_argument that names contradicting options: a loss that bursts this short
/// cannot reach, or a trace together with delay, jitter or loss.
void validate(const LinkOptions& options);

/// Reads "delay=25,jitter=5,loss=10,seed=3", a profile's name, "trace:FILE.csv", or a list of
/// these. "up." or "down." before an item limits it to one direction. Later items override earlier
/// ones. Throws std::invalid_argument that names the item and the remedy, and CsvError for a fault
/// in a trace.
TwoWayLinkOptions parse_link(std::string_view text);

/// A name for a list of items.
struct LinkProfile {
  std::string_view name;
  std::string_view items;
  std::string_view source;  // source of the numbers
};
extern const std::array<LinkProfile, 7> kLinkProfiles;

/// Keys with units and ranges, and the profiles, for --help.
std::string link_help();

}  // namespace feltwire
