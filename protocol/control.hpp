#pragma once
// The control messages (TCP) as values, and their frames.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/device_spec.hpp"
#include "protocol/datagram.hpp"
#include "protocol/session_parameters.hpp"

namespace feltwire::control {

inline constexpr std::size_t kMaxFrame = std::size_t{64} * 1024;  // [bytes] body of a frame
inline constexpr std::size_t kFrameLengthSize = 4;                // [bytes] the u32 before it
inline constexpr std::size_t kMaxName = 128;    // [bytes] of a client, scene or device name
inline constexpr std::size_t kMaxScenes = 256;  // of one server

struct JoinRequest {
  std::string client;
  std::string scene;
  DeviceSpec device;
  SessionParameters parameters;
};
struct JoinAccepted {
  std::uint64_t session = 0;
  std::uint16_t udp_port = 0;
  SessionParameters parameters;  // in force
  double silence_timeout = 0.0;  // [s]
  bool friction = false, rotation = false;
  Vec3 start_position = Vec3::Zero();  // [m] where a hand that knows nothing of the scene begins
  Vec3 start_normal = Vec3::UnitZ();   // unit, of the surface there
  double stiffness = 0.0;              // [N/m] of the scene's stiffest surface; 0: not said
};
struct LeaveRequest {
  std::uint64_t session = 0;
};
struct Left {
  std::uint64_t session = 0;
};
struct ListScenes {};
struct SceneEntry {
  std::string name;
  std::uint16_t udp_port = 0;
  std::uint32_t objects = 0, sessions = 0;
};
struct SceneList {
  std::vector<SceneEntry> scenes;
};
struct SetParameters {
  std::uint64_t session = 0;
  SessionParameters parameters;
};
struct ParametersSet {
  std::uint64_t session = 0;
  SessionParameters parameters;
};
enum class RefusalCode : std::uint8_t {
  malformed,
  unknown_scene,
  unknown_session,
  bad_device,
  bad_parameters,
  full,
  shutting_down
};
struct Refused {
  RefusalCode code = RefusalCode::malformed;
  std::string reason;  // for people
};

using Message = std::variant<JoinRequest, JoinAccepted, LeaveRequest, Left, ListScenes, SceneList,
                             SetParameters, ParametersSet, Refused>;

const char* name(RefusalCode code);

/// A whole frame: u32 length (little-endian, without itself), then the FlatBuffer.
/// Throws std::length_error when the body would be longer than kMaxFrame.
std::vector<std::uint8_t> encode(const Message& message);

/// The length of the body that follows these bytes; check it against kMaxFrame before reading on.
std::uint32_t frame_length(std::span<const std::uint8_t, kFrameLengthSize> bytes) noexcept;

/// The body of a frame (without its length), verified. nullopt when it is no valid message.
/// Numbers are not judged here: validate() does that.
std::optional<Message> decode(Bytes body);

}  // namespace feltwire::control
