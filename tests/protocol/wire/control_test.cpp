#include "protocol/wire/control.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/protocol/control_messages.hpp"

namespace feltwire::control {
namespace {

using test::body;
using test::request;
using test::round_trip;
using test::unusual_parameters;

TEST(Control, JoinRequestRoundTrip) {
  const JoinRequest sent = request();
  const JoinRequest got = round_trip(sent);
  EXPECT_EQ(got.client, sent.client);
  EXPECT_EQ(got.scene, sent.scene);
  EXPECT_EQ(got.parameters, sent.parameters);
  EXPECT_EQ(got.device.name, sent.device.name);
  EXPECT_EQ(got.device.translation_dof, 2);
  EXPECT_EQ(got.device.rotation_sensed, 3);
  EXPECT_EQ(got.device.rotation_actuated, 3);
  EXPECT_EQ(got.device.damping, 0.1);
  EXPECT_EQ(got.device.rotational_damping, 0.2);
  EXPECT_EQ(got.device.apparent_mass, 0.3);
  EXPECT_EQ(got.device.coulomb_friction, 0.4);
  EXPECT_EQ(got.device.position_resolution, 0.5);
  EXPECT_EQ(got.device.max_force, 0.6);
  EXPECT_EQ(got.device.continuous_force, 0.7);
  EXPECT_EQ(got.device.max_torque, 0.8);
  EXPECT_EQ(got.device.workspace, Vec3(0.9, 1.0, 1.1));
  EXPECT_EQ(got.role, Role::observer);
  EXPECT_TRUE(got.aes_256_gcm);
  EXPECT_EQ(got.tool, "");
}

TEST(Control, DampingTravelsAsANumberAlongAxesOrAsAMatrix) {
  const Mat3 matrix{{2.0, 0.5, -0.25}, {0.5, 3.0, 0.125}, {-0.25, 0.125, 4.0}};
  for (const Damping& damping : {Damping(0.5), Damping(Vec3(1, 2, 3)), Damping(matrix)}) {
    JoinRequest sent = request();
    sent.device.damping = damping;
    EXPECT_EQ(round_trip(sent).device.damping, damping);
    EXPECT_EQ(round_trip(sent).device.rotational_damping, Damping(0.2));
    std::swap(sent.device.damping, sent.device.rotational_damping);
    EXPECT_EQ(round_trip(sent).device.rotational_damping, damping);
  }
}

JoinAccepted accepted_with_all() {
  JoinAccepted accepted;
  accepted.session = 0xfedcba9876543210u;
  accepted.port_offset = 65535;
  accepted.parameters = SessionParameters{};
  accepted.silence_timeout = 2.5;
  accepted.friction = true;
  accepted.start_position = {1.0, 2.0, 3.0};
  accepted.start_normal = {0.0, -1.0, 0.0};
  accepted.stiffness = 1234.5;
  accepted.suite = CipherSuite::aes_256_gcm;
  return accepted;
}

/// FNV-1a hash of a frame.
std::uint64_t hash(const std::vector<std::uint8_t>& frame) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const std::uint8_t byte : frame) sum = (sum ^ byte) * 0x100000001b3u;
  return sum;
}

TEST(Control, TheVersionsOfBothProgramsTravelWhereTheyAreSaid) {
  JoinRequest wanted = request();
  JoinAccepted got = accepted_with_all();
  EXPECT_EQ(round_trip(wanted).version, "");
  wanted.version = got.version = "0.1.0 4d7d03fe1c52";
  EXPECT_EQ(round_trip(wanted).version, "0.1.0 4d7d03fe1c52");
  EXPECT_EQ(round_trip(got).version, "0.1.0 4d7d03fe1c52");
  wanted.version = got.version = std::string(kMaxName + 1, 'x');
  EXPECT_FALSE(decode(body(encode(wanted))));
  EXPECT_FALSE(decode(body(encode(got))));
}

// If a client requests no tool, or a scene has a single tool, the message must have no field for
// the tool.
TEST(Control, AToolIsSentOnlyWhereThereIsOne) {
  EXPECT_EQ(encode(request()).size(), 436u);
  EXPECT_EQ(hash(encode(request())), 0xebb103770318de82u);
  EXPECT_EQ(encode(accepted_with_all()).size(), 236u);
  EXPECT_EQ(hash(encode(accepted_with_all())), 0x4c283ae438cc8231u);

  JoinRequest wanted = request();
  JoinAccepted got = accepted_with_all();
  for (const std::string& tool :
       {std::string("key"), std::string("a\0b", 3), std::string(kMaxName, 'x')}) {
    wanted.tool = got.tool = tool;
    EXPECT_EQ(round_trip(wanted).tool, tool);
    EXPECT_EQ(round_trip(wanted).scene, "room");
    EXPECT_EQ(round_trip(got).tool, tool);
    EXPECT_EQ(round_trip(got).stiffness, 1234.5);
  }
  wanted.tool = got.tool = std::string(kMaxName + 1, 'x');
  EXPECT_FALSE(decode(body(encode(wanted))));
  EXPECT_FALSE(decode(body(encode(got))));
}

Workspace workspace_with_all() {
  Workspace workspace;
  workspace.add_box(Vec3(-0.5, -0.25, 0.0), Vec3(0.5, 0.25, 1.0));
  while (workspace.count < Workspace::kMostGiven) workspace.add({Vec3(0.6, 0.0, 0.8), -3.5});
  for (std::size_t i = 0; i < Workspace::kMostBodiesGiven; ++i)
    workspace.add_body({{Vec3(0.1, 0.2, 0.3), Quaternion(0.6, 0.0, 0.8, 0.0)},
                        Vec3(0.0, 0.01, 0.02),
                        0.001 * static_cast<double>(i + 1)});
  workspace.locked = {false, true, false};
  workspace.turning_locked = true;
  return workspace;
}

TEST(Control, AWorkspaceTravelsBothWaysWhereThereIsOne) {
  JoinRequest wanted = request();
  JoinAccepted got = accepted_with_all();
  EXPECT_FALSE(round_trip(wanted).workspace.limits());
  wanted.workspace = got.workspace = workspace_with_all();
  for (const Workspace& read : {round_trip(wanted).workspace, round_trip(got).workspace}) {
    ASSERT_EQ(read.count, Workspace::kMostGiven);
    for (std::size_t i = 0; i < read.count; ++i) {
      EXPECT_LE((read.walls[i].normal - got.workspace.walls[i].normal).norm(), 1e-15);
      EXPECT_EQ(read.walls[i].distance, got.workspace.walls[i].distance);
    }
    ASSERT_EQ(read.body_count, Workspace::kMostBodiesGiven);
    for (std::size_t i = 0; i < read.body_count; ++i) {
      const KeepOutBody &body = read.bodies[i], &sent = got.workspace.bodies[i];
      EXPECT_EQ(body.pose.position, sent.pose.position);
      EXPECT_LE((body.pose.orientation.coeffs() - sent.pose.orientation.coeffs()).norm(), 1e-15);
      EXPECT_EQ(body.half, sent.half);
      EXPECT_EQ(body.radius, sent.radius);
    }
    EXPECT_EQ(read.locked, got.workspace.locked);
    EXPECT_TRUE(read.turning_locked);
  }
  wanted.workspace = {};
  wanted.workspace.locked[2] = true;  // only a lock
  EXPECT_TRUE(round_trip(wanted).workspace.locked[2]);
  EXPECT_EQ(round_trip(wanted).workspace.count, 0u);
}

TEST(Control, AWorkspaceThatIsNoneIsRefused) {
  for (int which = 0; which <= 11; ++which) {
    JoinAccepted sent = accepted_with_all();
    sent.workspace = workspace_with_all();
    WorkspaceWall& wall = sent.workspace.walls[3];
    if (which == 0) wall.normal *= 1.01;
    if (which == 1) wall.normal.setZero();
    if (which == 2) wall.normal.y() = std::numeric_limits<double>::quiet_NaN();
    if (which == 3) wall.distance = 1001.0;
    if (which == 4) wall.distance = std::numeric_limits<double>::quiet_NaN();
    if (which == 5) sent.workspace.add(wall);  // exceeds the limit by one
    KeepOutBody& kept = sent.workspace.bodies[2];
    if (which == 6) kept.radius = 0.0009;
    if (which == 7) kept.radius = std::numeric_limits<double>::quiet_NaN();
    if (which == 8) kept.half.y() = -0.01;
    if (which == 9) kept.pose.orientation.coeffs() *= 1.01;
    if (which == 10) kept.pose.position.z() = -1001.0;
    if (which == 11) sent.workspace.add_body(kept);  // exceeds the limit by one
    JoinRequest asked = request();
    asked.workspace = sent.workspace;
    EXPECT_FALSE(decode(body(encode(sent)))) << which;
    EXPECT_FALSE(decode(body(encode(asked)))) << which;
  }
}

TEST(Control, FiguresAreAskedForWhereTheyAreWanted) {
  JoinRequest wanted = request();
  EXPECT_FALSE(round_trip(wanted).figures);
  wanted.figures = true;
  EXPECT_TRUE(round_trip(wanted).figures);
}

TEST(Control, SeatsForRobotsTravel) {
  JoinRequest wanted = request();
  EXPECT_EQ(round_trip(wanted).seat, "");
  wanted.seat = "left";
  EXPECT_EQ(round_trip(wanted).seat, "left");
  JoinAccepted accepted = accepted_with_all();
  EXPECT_TRUE(round_trip(accepted).seats.empty());
  for (const std::vector<std::string>& seats :
       {std::vector<std::string>{""}, {"a", "b"}, {"a", "b", "c", "d"}}) {
    accepted.seats = seats;
    EXPECT_EQ(round_trip(accepted).seats, seats);
  }
  accepted.seats = {"a", "b", "c", "d", "e"};
  EXPECT_FALSE(decode(body(encode(accepted))));
  SessionDescriptions list{{SessionDescription{}}, false};
  list.sessions[0].seat = "right";
  EXPECT_EQ(round_trip(list).sessions[0].seat, "right");
}

TEST(Control, OtherMessagesRoundTrip) {
  const JoinAccepted accepted = accepted_with_all();
  const JoinAccepted joined = round_trip(accepted);
  EXPECT_EQ(joined.session, accepted.session);
  EXPECT_EQ(joined.port_offset, 65535);
  EXPECT_EQ(joined.silence_timeout, 2.5);
  EXPECT_TRUE(joined.friction);
  EXPECT_FALSE(joined.rotation);
  EXPECT_EQ(joined.start_position, accepted.start_position);
  EXPECT_EQ(joined.start_normal, accepted.start_normal);
  EXPECT_EQ(joined.stiffness, 1234.5);
  EXPECT_EQ(joined.suite, CipherSuite::aes_256_gcm);
  EXPECT_EQ(joined.parameters, SessionParameters{});  // c1 and c2 must stay undefined.

  EXPECT_EQ(round_trip(LeaveRequest{3}).session, 3u);
  EXPECT_EQ(round_trip(Left{4}).session, 4u);
  round_trip(ListScenes{});
  const SceneList list = round_trip(SceneList{{{"a", 1, 2, 3}, {"b", 4, 5, 6}}});
  ASSERT_EQ(list.scenes.size(), 2u);
  EXPECT_EQ(list.scenes[1].name, "b");
  EXPECT_EQ(list.scenes[1].port_offset, 4);
  EXPECT_EQ(list.scenes[1].objects, 5u);
  EXPECT_EQ(list.scenes[1].sessions, 6u);
  EXPECT_TRUE(round_trip(SceneList{}).scenes.empty());
  const SetParameters set = round_trip(SetParameters{5, unusual_parameters()});
  EXPECT_EQ(set.session, 5u);
  EXPECT_EQ(set.parameters, unusual_parameters());
  const ParametersSet was_set = round_trip(ParametersSet{6, unusual_parameters()});
  EXPECT_EQ(was_set.session, 6u);
  EXPECT_EQ(was_set.parameters, unusual_parameters());
  EXPECT_EQ(round_trip(Authenticate{Secret("fw_x")}).token.text(), "fw_x");
  const Authenticated in = round_trip(Authenticated{"anna", "*", Role::admin});
  EXPECT_EQ(in.client, "anna");
  EXPECT_EQ(in.scene, "*");
  EXPECT_EQ(in.role, Role::admin);
  EXPECT_EQ(round_trip(Evict{7}).session, 7u);
  EXPECT_EQ(round_trip(Evicted{8}).session, 8u);
  EXPECT_EQ(round_trip(ListSessions{9}).after, 9u);
  const SessionList sessions =
      round_trip(SessionList{{{1, "a", "b", Role::observer}, {2, "c", "d", Role::admin}}, true});
  ASSERT_EQ(sessions.sessions.size(), 2u);
  EXPECT_EQ(sessions.sessions[1].session, 2u);
  EXPECT_EQ(sessions.sessions[1].client, "c");
  EXPECT_EQ(sessions.sessions[1].scene, "d");
  EXPECT_EQ(sessions.sessions[1].role, Role::admin);
  EXPECT_TRUE(sessions.more);
  EXPECT_EQ(round_trip(ReloadScene{"a"}).scene, "a");
  EXPECT_EQ(round_trip(SceneReloaded{"b"}).scene, "b");
  const MaterialChange change{.object = "o",
                              .stiffness = 1.0,
                              .damping = 2.0,
                              .static_friction = 3.0,
                              .dynamic_friction = 4.0,
                              .viscous_friction = 5.0};
  EXPECT_EQ(round_trip(SetMaterial{"a", change}).change, change);
  EXPECT_EQ(round_trip(SetMaterial{"a", {.object = "o"}}).change, MaterialChange{.object = "o"});
  EXPECT_EQ(round_trip(SetGravity{"a", {1, 2, 3}}).gravity, Vec3(1, 2, 3));
  EXPECT_EQ(round_trip(SceneChanged{"a", "what"}).what, "what");
  EXPECT_EQ(round_trip(WriteFlightRecord{"a"}).scene, "a");
  EXPECT_EQ(round_trip(FlightRecordWritten{"a", "b.mcap"}).scene, "a");
  EXPECT_EQ(round_trip(FlightRecordWritten{"a", "b.mcap"}).file, "b.mcap");
  EXPECT_EQ(round_trip(RecordScene{"a", RecordingAction::stop}).scene, "a");
  EXPECT_EQ(round_trip(RecordScene{"a", RecordingAction::stop}).action, RecordingAction::stop);
  SceneRecordings recordings{"a", "folder", "", 1.5, 2, RecordingEnd::room, {{"b", 3}, {"c", 4}}};
  EXPECT_EQ(round_trip(recordings), recordings);
  recordings.running = "d";
  EXPECT_EQ(round_trip(recordings), recordings);
  recordings.kept.resize(kMaxKept + 1);
  EXPECT_FALSE(decode(body(encode(recordings))));
  EXPECT_EQ(round_trip(DescribeSessions{"a", 7}).after, 7u);
  EXPECT_EQ(round_trip(GetCounters{}).scene, "");
  EXPECT_EQ(round_trip(GetCounters{"a"}).scene, "a");
  EXPECT_EQ(round_trip(Counters{{{"a", 1}, {"b", 2}}}).counters[1].value, 2u);
  for (int code = 0; code <= static_cast<int>(RefusalCode::bad_ticket); ++code) {
    const Refused refused = round_trip(Refused{static_cast<RefusalCode>(code), "because"});
    EXPECT_EQ(static_cast<int>(refused.code), code);
    EXPECT_EQ(refused.reason, "because");
    EXPECT_STRNE(name(refused.code), "unknown");
  }
}

TEST(Control, HostsOfAFleetRoundTrip) {
  FleetHost host{"2001:db8::7", 6720, {}};
  host.fingerprint[31] = 9;
  const Redirected redirected = round_trip(Redirected{host, "v4.public.x", {5, 6}});
  EXPECT_EQ(redirected.host, host);
  EXPECT_EQ(redirected.ticket, "v4.public.x");
  EXPECT_EQ(redirected.epoch, (Epoch{5, 6}));

  JoinAccepted accepted;
  accepted.session = 1;
  accepted.epoch = {7, 8};
  accepted.hosts.assign(kMaxFleetHosts, host);
  EXPECT_EQ(round_trip(accepted).epoch, (Epoch{7, 8}));
  EXPECT_EQ(round_trip(accepted).hosts, accepted.hosts);
  accepted.hosts.push_back(host);
  EXPECT_EQ(decode(Bytes(encode(accepted)).subspan(kFrameLengthSize)), std::nullopt);

  JoinRequest asked{"c", "s", builtin_device("simulated"), {}};
  asked.follows_redirects = true;
  asked.epoch = {9, 10};
  asked.ticket.assign(kMaxTicket, 't');
  EXPECT_TRUE(round_trip(asked).follows_redirects);
  EXPECT_EQ(round_trip(asked).epoch, (Epoch{9, 10}));
  EXPECT_EQ(round_trip(asked).ticket, asked.ticket);
  asked.ticket += 't';
  EXPECT_EQ(decode(Bytes(encode(asked)).subspan(kFrameLengthSize)), std::nullopt);
}

/// A reason may quote a complete file. The frame must be valid for any length of the reason.
TEST(Control, AReasonOfAnyLengthIsSent) {
  const auto sent = [](const std::string& reason) {
    return round_trip(Refused{RefusalCode::bad_scene, reason}).reason;
  };
  const std::string fits(kMaxReason, 'x');
  EXPECT_EQ(sent(fits), fits);
  const std::string cut = std::string(kMaxReason - 6, 'x') + " [...]";
  for (const std::size_t size : {kMaxReason + 1, kMaxFrame - 1, kMaxFrame, 10 * kMaxFrame})
    EXPECT_EQ(sent(std::string(size, 'x')), cut) << size;
}

/// Characters of 1 to 4 bytes are at every position of the cut. None may be split.
TEST(Control, AReasonIsCutBetweenCharacters) {
  for (const std::string character : {"a", "\u00e9", "\u20ac", "\U0001f44b"})
    for (std::size_t before = 0; before < 4; ++before) {
      std::string text(before, '.');
      for (int n = 0; n < 20; ++n) text += character;
      const std::string cut = shortened(text, 18);
      EXPECT_LE(cut.size(), 18u);
      EXPECT_GT(cut.size() + character.size(), 18u);
      ASSERT_TRUE(cut.ends_with(" [...]"));
      const std::string kept = cut.substr(0, cut.size() - 6);
      EXPECT_TRUE(text.starts_with(kept));
      EXPECT_EQ((kept.size() - before) % character.size(), 0u) << kept;
    }
  // Text that is not UTF-8 may be cut anywhere. The search for a boundary must end.
  EXPECT_EQ(shortened(std::string(100, '\x80'), 18), std::string(12, '\x80') + " [...]");
}

TEST(Control, FrameLengthIsLittleEndian) {
  const std::array<std::uint8_t, 4> bytes = {0x04, 0x03, 0x02, 0x01};
  EXPECT_EQ(frame_length(bytes), 0x01020304u);
  const auto frame = encode(ListScenes{});
  EXPECT_EQ(frame[0], frame.size() - 4);
  EXPECT_EQ(frame[3], 0);
}

TEST(Control, TextsArriveWholeWhateverIsInThem) {
  using std::string_literals::operator""s;
  JoinRequest r = request();
  r.client = "a\0b"s;
  r.scene = "\0"s;
  r.device.name = "\0\0"s;
  const JoinRequest got = round_trip(r);
  EXPECT_EQ(got.client, r.client);
  EXPECT_EQ(got.scene, r.scene);
  EXPECT_EQ(got.device.name, r.device.name);
  EXPECT_EQ(round_trip(SceneList{{{"c\0d"s, 1, 2, 3}}}).scenes[0].name, "c\0d"s);
  EXPECT_EQ(round_trip(Refused{RefusalCode::full, "no\0room"s}).reason, "no\0room"s);
}

/// The codec must accept any name of a method. Only the program checks whether the method exists.
TEST(Control, ANameOfAMethodArrivesUpToItsLimit) {
  SessionParameters p;
  for (const std::string& name :
       {std::string("no_such_method"), std::string(), std::string(kLongestMethodName, 'm')}) {
    p.mode = name;
    const auto message = decode(body(encode(SetParameters{1, p})));
    ASSERT_TRUE(message) << name;
    EXPECT_EQ(std::get<SetParameters>(*message).parameters, p);
  }
}

}  // namespace
}  // namespace feltwire::control
