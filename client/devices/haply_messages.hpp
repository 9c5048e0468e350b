#pragma once
// The JSON of Haply's service, as its versions speak it: what a message tells of the devices, and
// the commands. No socket; nothing allocates.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/types.hpp"

namespace feltwire::haply {

/// How devices stand in a message, and so what its service understands.
enum class Dialect {
  keyed,    // 3.0: an object, by id
  values,   // 3.1: a list; forces are "values"
  session,  // 3.4 and later: a list, with a session; forces are "vector"
};

/// The part of a message about one Inverse3 or Minverse, in the service's axes.
struct Told {
  std::string_view id;           // points into the message
  std::optional<Vec3> position;  // [m]
  std::optional<Vec3> force;     // [N] that is applied, where it says so
  std::optional<bool> calibrated;
  // Only the first message has these; neutral values where it has not.
  std::string_view permutation = "XYZ";
  Vec3 mount = Vec3::Zero(), scale = Vec3::Ones();
  bool turned = false;  // the mount is
  double damping = 0.0;
  std::optional<double> gate;  // gain of the force gate
  bool compensates_gravity = false;
};

struct Message {
  Dialect dialect = Dialect::values;
  std::size_t devices = 0;                     // that it tells of
  Told told;                                   // of the one that was asked for
  std::optional<std::array<bool, 3>> buttons;  // of the first grip
};

/// What `text` tells of the device `id`, or of its first where that is empty. None: it is no JSON
/// object, it is nested more than 32 deep, or it tells of no such device.
std::optional<Message> read_message(std::string_view text, std::string_view id) noexcept;

inline constexpr std::size_t kMostCommand = 512;
inline constexpr std::size_t kMostId = 64;

/// The command that puts `force` [N, the service's axes] on the device `id` for one tick. `first`:
/// it also names the session and switches the service's own damping off, where it has them. Returns
/// the text's length. The id must have at most kMostId plain characters.
std::size_t write_command(Dialect dialect, std::string_view id, const Vec3& force, bool first,
                          std::span<char, kMostCommand> text) noexcept;

}  // namespace feltwire::haply
