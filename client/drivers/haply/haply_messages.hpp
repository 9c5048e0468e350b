#pragma once
// The JSON messages of Haply's service in all its versions: the devices in a message, and the
// commands. It uses no socket and allocates nothing.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/types.hpp"

namespace feltwire::haply {

/// The form of the devices in a message. It shows which commands the service understands.
enum class Dialect {
  keyed,    // 3.0: an object, by id
  values,   // 3.1: a list; forces are "values"
  session,  // 3.4 and later: a list, with a session; forces are "vector"
};

/// The part of a message about one Inverse3 or Minverse, in the service's axes.
struct HaplyState {
  std::string_view id;           // points into the message
  std::optional<Vec3> position;  // [m]
  std::optional<Vec3> force;     // [N] the applied force, if the message has it
  std::optional<bool> calibrated, ready, powered, in_use;
  // Only the first message has these. Otherwise they have neutral values.
  std::string_view permutation = "XYZ";
  Vec3 mount = Vec3::Zero(), scale = Vec3::Ones();
  bool turned = false;  // the mount is turned
  double damping = 0.0;
  std::optional<double> gate;  // gain of the force gate
  bool compensates_gravity = false;
  bool left_handed = false;

  /// The service hands positions and forces through as they are: it turns, moves, scales and damps
  /// nothing.
  bool neutral() const noexcept;
};

struct Message {
  Dialect dialect = Dialect::values;
  std::size_t devices = 0;                     // number of devices in the message
  HaplyState told;                             // the requested device
  std::optional<std::array<bool, 3>> buttons;  // buttons of the first grip
  std::optional<Quaternion> orientation;       // of the first grip, in the service's axes
};

/// Reads the data of the device `id` from `text`, or of the first device if `id` is empty. Empty if
/// `text` is no JSON object, is nested more than 32 deep, or does not contain the device.
std::optional<Message> read_message(std::string_view text, std::string_view id) noexcept;

/// Whether `text` has the list of devices that every service of version 3 sends, be it empty.
bool lists_devices(std::string_view text) noexcept;

inline constexpr std::size_t kMostCommand = 512;
inline constexpr std::size_t kMostId = 64;

/// Builds the command that puts `force` [N, the service's axes] on the device `id` for one tick.
/// With `first` it also names the session and switches the service's own damping off, if the
/// version has them. Returns the length of the text. The id must have at most kMostId plain
/// characters.
std::size_t write_command(Dialect dialect, std::string_view id, const Vec3& force, bool first,
                          std::span<char, kMostCommand> text) noexcept;

}  // namespace feltwire::haply
