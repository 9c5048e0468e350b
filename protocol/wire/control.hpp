#pragma once
// The control messages (TCP) as values, and their frames.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/base/time_counts.hpp"
#include "core/device/device_spec.hpp"
#include "core/local_model/prefetched_geometry.hpp"
#include "core/material/material.hpp"
#include "core/teleoperation/workspace.hpp"
#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/session_keys.hpp"
#include "protocol/crypto/tls.hpp"
#include "protocol/fleet/epoch.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/material_change.hpp"
#include "protocol/session/protocol_versions.hpp"
#include "protocol/session/role.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire::control {

inline constexpr std::size_t kMaxFrame = std::size_t{64} * 1024;  // [bytes] body of a frame
inline constexpr std::size_t kFrameLengthSize = 4;                // [bytes] the u32 before it
inline constexpr std::size_t kMaxName = 128;  // [bytes] of a client, scene, device or tool name
/// [bytes] of a refusal's reason; encode() cuts a longer one.
inline constexpr std::size_t kMaxReason = 4096;
inline constexpr std::size_t kMaxKept = 64;     // recordings of one SceneRecordings
inline constexpr std::size_t kMaxScenes = 256;  // of one server
/// [bytes] body of a frame before the token was shown: a long frame of a stranger causes no work.
inline constexpr std::size_t kMaxFirstFrame = 512;
inline constexpr std::size_t kMaxSessionEntries = 200;  // of one SessionList
inline constexpr std::size_t kMaxDescriptions = 64;     // of one SessionDescriptions
inline constexpr std::size_t kMaxMaterials = 1000;      // of one SceneDescription
inline constexpr std::size_t kMaxSurfaces = 200;        // of one SurfaceList
inline constexpr std::size_t kMaxPart = 1200;      // vertices, and triangles, of one SurfacePart
inline constexpr std::size_t kMaxShapes = 100;     // of one ShapeDescriptions
inline constexpr std::size_t kMaxLengths = 8;      // of one shape
inline constexpr std::size_t kMaxTicket = 2048;    // [bytes]
inline constexpr std::size_t kMaxFleetHosts = 4;   // of one JoinAccepted
inline constexpr double kShortestSilence = 0.1;    // [s] of a silence timeout
inline constexpr double kLongestSilence = 3600.0;  // [s] of a silence timeout

struct JoinRequest {
  std::string client;
  std::string scene;
  DeviceSpec device;
  SessionParameters parameters;
  Role role = Role::operator_;
  bool aes_256_gcm = false;  // this CPU is fast at it; every client has ChaCha20-Poly1305
  std::string tool = {};     // the tool for the hand; empty: the scene's first
  std::string version =
      {};                // of the client (core/build_info), for the server's log; empty: not said
  bool figures = false;  // for an observer: views have the figures of hands (scene_view.hpp)
  ChangesTaken takes = {};         // changes that an admin may make at the client while it runs
  Workspace workspace = {};        // for a follower: its own; at most Workspace::kMostGiven walls
  double lead_share = 0.0;         // for a hand (lead_share.hpp); the server sets it from the token
  std::string seat = {};           // for a follower: the name of its seat; empty: the only one
  bool follows_redirects = false;  // the client knows Redirected
  Epoch epoch = {};                // the highest of the scene that the client has seen
  std::string ticket = {};         // of the Redirected that sent the client here; empty: none did
};
/// A host of a fleet, for a client.
struct FleetHost {
  std::string address;  // an IP address
  std::uint16_t port = 0;
  Fingerprint fingerprint{};  // of its certificate

  friend bool operator==(const FleetHost&, const FleetHost&) = default;
};
struct JoinAccepted {
  std::uint64_t session = 0;
  std::uint16_t port_offset = 0;  // of the UDP port, relative to the dialled control port
  SessionParameters parameters;   // in force
  double silence_timeout = 0.0;   // [s]
  bool friction = false, rotation = false;
  Vec3 start_position = Vec3::Zero();  // [m] start of a hand that does not know the scene
  Vec3 start_normal = Vec3::UnitZ();   // unit, of the surface there
  double stiffness = 0.0;              // [N/m] of the scene's stiffest surface; 0: not known
  CipherSuite suite = CipherSuite::chacha20_poly1305;  // of the datagrams
  std::string tool;     // the tool of the hand; empty: the scene's only one
  std::string version;  // of the server (core/build_info), for the report; empty: not said
  Workspace workspace;  // for a follower: that of its seat
  std::vector<std::string> seats = {};  // names of the scene's seats for robots, at most kMostSeats
  bool lists_surfaces = false;          // the server knows ListSurfaces
  // The secrets of the datagrams as they came, wiped at the end. take_keys() checks their length.
  Secret secret_up = {}, secret_down = {};
  Epoch epoch = {};                   // of the scene; term 0: the server is in no fleet
  std::vector<FleetHost> hosts = {};  // to ask if this one is silent, at most kMaxFleetHosts
};
/// The scene is served by another host.
struct Redirected {
  FleetHost host;
  std::string ticket;  // for the JoinRequest there
  Epoch epoch;         // of the scene there
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
  std::uint16_t port_offset = 0;
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
  shutting_down,
  unauthenticated,
  forbidden,
  too_many,
  not_supported,
  bad_scene,
  unknown_tool,
  failed,     // the server failed (no memory, for example); nothing was changed
  bad_ticket  // it is used, expired, or not for this scene, client, host or epoch
};
struct Refused {
  RefusalCode code = RefusalCode::malformed;
  std::string reason;  // for people
};
struct Authenticate {
  Secret token;
  ProtocolVersions versions = {};  // of the client
};
struct Authenticated {
  std::string client, scene;  // the token's client, and the scene that it opens; *: any
  Role role = Role::observer;
  ProtocolVersions versions = {};  // of the server
};
struct Evict {
  std::uint64_t session = 0;
};
struct Evicted {
  std::uint64_t session = 0;
};
struct ListSessions {
  std::uint64_t after = 0;  // lists sessions with greater ids; 0: from the first
};
struct SessionEntry {
  std::uint64_t session = 0;
  std::string client, scene;
  Role role = Role::observer;
};
struct SessionList {
  std::vector<SessionEntry> sessions;  // at most kMaxSessionEntries, by rising id
  bool more = false;                   // there are sessions with greater ids
};
struct ReloadScene {
  std::string scene;
};
struct SceneReloaded {
  std::string scene;
};

struct SetMaterial {
  std::string scene;
  MaterialChange change;
};
struct SetGravity {
  std::string scene;
  Vec3 gravity = Vec3::Zero();  // [m/s^2] on moving objects
};
struct SetLink {
  std::uint64_t session = 0;
  LinkQuality link;  // for its client to emulate
};
struct SetLead {
  std::uint64_t session = 0;
  double share = 0.0;  // lead_share.hpp
};
struct SceneChanged {
  std::string scene;
  std::string what;  // for people: the old and the new value
};
struct DescribeSessions {
  std::string scene;
  std::uint32_t after = 0;  // lists sessions with greater numbers; 0: from the first
};
struct SessionDescription {
  std::uint32_t number = 0;  // from 1 in the order they joined the scene
  std::uint64_t session = 0;
  std::string client;  // the name that it gives itself
  std::string device;
  std::string tool;  // the requested one; empty: the scene's first
  Role role = Role::operator_;
  SessionParameters parameters;
  std::uint64_t samples = 0;         // taken so far
  std::uint64_t missed = 0;          // lost on the way so far
  std::optional<double> round_trip;  // [s] as its client reports
  double delivered = 0.0;            // [J] to the hand so far
  double burned = 0.0;               // [J] lower bound of the device's burned energy so far
  std::optional<double> balance;     // [J] of its client's account
  ClientChangeState changes;
  double lead_share = 0.0;  // with which it leads a robot (lead_share.hpp)
  std::string seat = {};    // a follower's, or of the robot that it leads; empty: none, or the only
  std::optional<double> seconds;       // [s] since it began
  std::optional<double> hand_damping;  // [N s/m] of the hand, that its client's shaping counts on
  HandTimesHeard times;                // how punctual its client is
};
struct SessionDescriptions {
  std::vector<SessionDescription> sessions;  // at most kMaxDescriptions, by rising number
  bool more = false;                         // there are sessions with greater numbers
};
struct DescribeScene {
  std::string scene;
  std::uint32_t from = 0;  // materials of the objects from this index on
};
/// The times that a server counted in a scene since it began. Empty: not said.
struct SceneTimes {
  std::optional<TimeCounts> answers;     // from the processing of a datagram to its answer
  std::optional<TimeCounts> world_late;  // how late the thread woke for what moves
};
struct SceneDescription {
  std::uint32_t version = 0;        // 1, and one more with each reload
  std::uint32_t changes = 0;        // live ones of materials and gravity so far
  std::optional<Vec3> gravity;      // [m/s^2]; empty: nothing moves
  std::uint32_t objects = 0;        // of the scene
  std::vector<Material> materials;  // at most kMaxMaterials
  SceneTimes times = {};
};
struct WriteFlightRecord {
  std::string scene;
};
struct FlightRecordWritten {
  std::string scene;
  std::string file;  // on the server's machine; encode() cuts one longer than kMaxReason
};
enum class RecordingAction : std::uint8_t { look, start, stop };
/// The reason why a recording has ended: nobody's, an admin's, the server's limits, a failure.
enum class RecordingEnd : std::uint8_t { none, asked, size, time, room, failed };
struct RecordScene {
  std::string scene;
  RecordingAction action = RecordingAction::look;
};
struct KeptRecording {
  std::string name;
  std::uint64_t bytes = 0;
  friend bool operator==(const KeptRecording&, const KeptRecording&) = default;
};
struct SceneRecordings {
  std::string scene;
  std::string folder;       // on the server's machine; encode() cuts one longer than kMaxReason
  std::string running;      // the name of the file that is written; empty: none
  double seconds = 0.0;     // [s] of the running recording so far; else of the last one
  std::uint64_t bytes = 0;  // likewise
  RecordingEnd ended = RecordingEnd::none;  // of the last one; none: there was none, or one runs
  std::vector<KeptRecording> kept = {};     // complete ones, the newest first, at most kMaxKept
  friend bool operator==(const SceneRecordings&, const SceneRecordings&) = default;
};
struct GetCounters {
  std::string scene;  // empty: of the control port
};
struct Counter {
  std::string name;
  std::uint64_t value = 0;
};
struct Counters {
  std::vector<Counter> counters;
};

/// Asks which surfaces the client of a session may have in full.
struct ListSurfaces {
  std::uint64_t session = 0;
};
struct SurfaceEntry {
  SurfaceData surface;  // without vertices and triangles
  std::uint32_t vertices = 0, triangles = 0;
};
struct SurfaceList {
  std::uint32_t version = 0;           // PrefetchedSurfaces::version()
  std::vector<SurfaceEntry> surfaces;  // at most kMaxSurfaces
};
/// Asks for the part of a surface after so many vertices and triangles.
struct GetSurface {
  std::uint64_t session = 0;
  std::uint32_t version = 0;
  std::uint16_t object = 0;
  std::uint32_t vertices = 0, triangles = 0;
};
struct SurfacePart {
  std::vector<Vec3> vertices;  // [m] at most kMaxPart
  std::vector<Triangle> triangles;
};
/// The session's client has these surfaces in full now, and no others.
struct TakeSurfaces {
  std::uint64_t session = 0;
  std::uint32_t version = 0;
  std::vector<std::uint16_t> objects;  // at most kMaxSurfaces
};
struct SurfacesTaken {
  std::uint64_t session = 0;
};

/// Asks which tool and solids the client of a session may have in full.
struct ListSolids {
  std::uint64_t session = 0;
};
struct SolidEntry {
  SolidData solid;                            // without its mesh
  std::uint32_t vertices = 0, triangles = 0;  // of its mesh; 0: it is a primitive
};
struct SolidList {
  std::uint32_t version = 0;            // PrefetchedTool::version
  std::optional<BodyData> body = {};    // without its points; empty: there is nothing to have
  std::uint32_t points = 0;             // of the body
  std::vector<SolidEntry> solids = {};  // at most kMaxSurfaces; of shapes that this program knows
};
/// Asks for the points of the body after so many.
struct GetBodyPoints {
  std::uint64_t session = 0;
  std::uint32_t version = 0;
  std::uint32_t points = 0;
};
struct BodyPoints {
  std::vector<Vec3> points;  // [m] at most kMaxPart
};

/// A list of shapes of a scene, for a client that draws them.
enum class ShapeGroup : std::uint8_t { objects, guides, tools };
struct DescribeShapes {
  std::string scene;
  ShapeGroup group = ShapeGroup::objects;
  std::uint32_t from = 0;  // lists shapes from this index on
};
struct ShapeDescription {
  std::string name;
  std::string shape;  // its name in a scene file, or "grid", "mesh", "points", "everywhere"
  std::vector<double> lengths = {};  // [m] at most kMaxLengths
  Pose pose = {};                    // of the shape; of what moves, at the start
  bool parts = false;                // GetShape has its vertices, and triangles if it is a surface
  bool moves = false;                // views have its pose
  bool from_inside = false;
  std::string material = {};  // of an object: its name in the scene file; empty: none
  std::string action = {};    // of a guide: its name in a scene file
  bool closed = false;        // of a curve
};
struct ShapeDescriptions {
  std::uint32_t version = 0;             // of the scene, as of SceneDescription
  std::string scene;                     // for people; encode() cuts one longer than kMaxReason
  std::uint32_t count = 0;               // of the group
  std::vector<ShapeDescription> shapes;  // at most kMaxShapes
};
/// Asks for the part of a shape after so many vertices and triangles.
struct GetShape {
  std::string scene;
  std::uint32_t version = 0;
  ShapeGroup group = ShapeGroup::objects;
  std::uint32_t index = 0;
  std::uint32_t vertices = 0, triangles = 0;
};
struct ShapePart {
  std::uint32_t all_vertices = 0, all_triangles = 0;  // of the shape
  std::vector<Vec3> vertices = {};                    // [m] in the shape's frame, at most kMaxPart
  std::vector<Triangle> triangles = {};               // at most kMaxPart
};

using Message =
    std::variant<JoinRequest, JoinAccepted, LeaveRequest, Left, ListScenes, SceneList,
                 SetParameters, ParametersSet, Refused, Authenticate, Authenticated, Evict, Evicted,
                 ListSessions, SessionList, ReloadScene, SceneReloaded, SetMaterial, SetGravity,
                 SceneChanged, DescribeSessions, SessionDescriptions, GetCounters, Counters,
                 SetLink, SetLead, WriteFlightRecord, FlightRecordWritten, DescribeScene,
                 SceneDescription, ListSurfaces, SurfaceList, GetSurface, SurfacePart, TakeSurfaces,
                 SurfacesTaken, ListSolids, SolidList, GetBodyPoints, BodyPoints, DescribeShapes,
                 ShapeDescriptions, GetShape, ShapePart, Redirected, RecordScene, SceneRecordings>;

const char* name(RefusalCode code);

/// At most `most` bytes of the text. A longer one is cut between two characters of UTF-8, and ends
/// in " [...]". Precondition: most >= 6.
std::string shortened(const std::string& text, std::size_t most);

/// A whole frame: u32 length (little-endian, without itself), then the FlatBuffer. A refusal's
/// reason longer than kMaxReason is shortened(). Throws std::length_error if the body would be
/// longer than kMaxFrame.
std::vector<std::uint8_t> encode(const Message& message);

/// The length of the body that follows these bytes; check it against kMaxFrame before reading on.
std::uint32_t frame_length(std::span<const std::uint8_t, kFrameLengthSize> bytes) noexcept;

/// The body of a frame (without its length), verified. nullopt if it is no valid message. Numbers
/// are not checked here: validate() does that.
std::optional<Message> decode(Bytes body);

}  // namespace feltwire::control
