#pragma once
// The datagrams as values. PROTOCOL.md has their bytes; codec.hpp converts.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/contact_normals.hpp"
#include "core/base/types.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/local_model/body_model.hpp"
#include "core/local_model/local_model.hpp"
#include "core/teleoperation/robot.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

using Bytes = std::span<const std::uint8_t>;

inline constexpr std::size_t kMaxDatagram = 1200;  // [bytes] header, payload and tag
inline constexpr double kMaxPosition = 1e3;        // [m] on each axis; no hand is farther away
inline constexpr double kUnitTolerance = 1e-3;     // of a quaternion's squared norm

enum class DatagramKind : std::uint8_t {
  samples = 1,
  reply = 2,
  goodbye = 3,
  follower_state = 4,
  follower_target = 5
};
enum class GoodbyeReason : std::uint8_t {
  leaving,
  shutting_down,
  evicted,
  flooding,
  failed,     // the server could not continue the session
  disturbing  // the hand broke the simulation of the moving objects
};

/// The header before every payload.
struct Header {
  DatagramKind kind = DatagramKind::samples;
  std::uint64_t session = 0;
  std::uint64_t packet_number = 0;  // counted by the sender from 1
};

/// A servo sample of a device. Forces on the hand, world frame.
struct Sample {
  std::uint64_t index = 0;     // counted by the client from 1
  Nanoseconds client_time{0};  // client's monotonic clock when the device was read
  Pose pose;                   // orientation stays identity for devices that do not sense it
  Command held;  // held by the device from this sample to the next (float32 on the wire)
};

/// The newest sample first, then up to k earlier ones.
struct SampleBatch {
  std::array<Sample, kMaxRedundancy + 1> samples;
  int count = 0;
  bool rotation = false;  // orientation and torque travel too
  /// Index of the sample that travelled before the oldest one here, 0: none. The client left out
  /// the samples between these two; they were not lost on the way.
  std::uint64_t previous = 0;
  std::optional<HandReport> report;  // of the newest sample; absent in most datagrams
  std::optional<Lead> lead;          // of the newest sample; empty: this hand leads no robot
  std::span<const Sample> view() const { return {samples.data(), static_cast<std::size_t>(count)}; }
};

/// When a reply was made, by the server's monotonic clock.
struct ServerTimes {
  Nanoseconds received{0}, sent{0};
};

/// The changes that the server's bound made to the command of a reply.
struct ServerBound {
  double ratio = 1.0;  // |rendered| / |commanded|, float32 on the wire
  bool active = false, saturated = false, refused = false;
};

struct Reply {
  std::uint64_t sample_index = 0;  // the newest sample that the command was computed from
  Nanoseconds client_time{0};      // that sample's, returned
  ServerTimes server_times;
  Command command;
  bool rotation = false;    // torque travels too
  ChannelEnergy delivered;  // [J] at the real port so far, from the held forces the client reported
  ServerBound bound;
  bool gap = false;         // among the samples that this answers
  bool recovering = false;  // moving objects were put back to a good state and are felt in part
  /// The number of reloads of the scene during this session, modulo 256.
  std::uint8_t reloads = 0;
  std::uint64_t withheld = 0;  // datagrams that needed no reply (deadband), so far
  bool predicted = false;      // `rates` travel too
  Command rates;               // [N/s], [N m/s] of the command, float32 on the wire
  /// The normals of the walls whose forces add up to command.elastic; float32 on the wire. They
  /// travel if there are two or more.
  ContactNormals normals;
  bool modelled = false;         // `model` travels too
  LocalModel model;              // its lengths relative to its center float32 on the wire
  bool body_modelled = false;    // `body` travels too
  BodyModel body;                // float32 and less on the wire
  std::optional<Remote> remote;  // for a session that leads a robot
  /// The change that the client has not acknowledged yet; float32 on the wire.
  std::optional<ClientChange> change;
  /// The server asks for a datagram only every so many packet intervals (server/scene/pace.hpp).
  std::uint8_t pace = 1;
};

/// Why a datagram was dropped; each has a counter. The order is the order of the checks in
/// PROTOCOL.md.
enum class DropReason : std::uint8_t {
  none,           // not dropped
  size,           // shorter than the header or longer than kMaxDatagram
  magic,          // not a feltwire datagram
  version,        // another protocol version
  kind,           // unknown kind, or one that this side does not receive
  reserved,       // reserved bytes not zero
  session,        // no such session here
  packet_number,  // zero, or seen before, or too old to tell
  sealed,         // not sealed by the session's other end, or with an old key
  rate,           // the session sends more samples than allowed
  malformed,      // the payload is not a valid FlatBuffer
  count,          // no sample, too many, or rotations that do not match
  order,          // sample indices not strictly falling
  not_finite,     // NaN, infinity, or an invalid quaternion or model
  stale,          // it contains nothing newer than before
  count_of_reasons
};
inline constexpr std::size_t kDropReasons = static_cast<std::size_t>(DropReason::count_of_reasons);
const char* name(DropReason reason);

}  // namespace feltwire
