#include "protocol/wire/control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control_generated.h"
#include "tests/protocol/misaligned.hpp"

namespace feltwire::control {
namespace {

Bytes body(const std::vector<std::uint8_t>& frame) {
  return Bytes(frame).subspan(kFrameLengthSize);
}

template <class Value>
Value round_trip(const Value& value) {
  const auto frame = encode(value);
  EXPECT_EQ(
      frame_length(std::span<const std::uint8_t, kFrameLengthSize>(frame.data(), kFrameLengthSize)),
      body(frame).size());
  const auto message = decode(body(frame));
  EXPECT_TRUE(message.has_value());
  return std::get<Value>(message.value());
}

SessionParameters unusual_parameters() {
  SessionParameters p;
  p.mode = "per_axis_projected";
  p.projection = Projection::joint;
  p.storage = Storage::elastic;
  p.side = BoundingSide::client;
  p.servo_period = 2.5e-4;
  p.redundancy = 7;
  p.operator_damping = 0.25;
  p.velocity_cutoff = 120;
  p.hold_time = 0.05;
  p.c1 = 900;
  p.c2 = 450;
  p.reference = PassivityReference::following;
  p.coupling_stiffness = 300;
  p.coupling_damping = 0.2;
  p.tool_mass = 0.07;
  p.packet_interval = 300;
  p.batch = 2;
  p.position_deadband = 0.05;
  p.force_deadband = 0.1;
  p.predictor = Predictor::linear;
  p.keep_alive = 0.015;
  p.local_model = true;
  return p;
}

void expect_same(const SessionParameters& a, const SessionParameters& b) {
  EXPECT_EQ(a.mode, b.mode);
  EXPECT_EQ(a.projection, b.projection);
  EXPECT_EQ(a.storage, b.storage);
  EXPECT_EQ(a.side, b.side);
  EXPECT_EQ(a.servo_period, b.servo_period);
  EXPECT_EQ(a.redundancy, b.redundancy);
  EXPECT_EQ(a.operator_damping, b.operator_damping);
  EXPECT_EQ(a.velocity_cutoff, b.velocity_cutoff);
  EXPECT_EQ(a.hold_time, b.hold_time);
  EXPECT_EQ(a.c1, b.c1);
  EXPECT_EQ(a.c2, b.c2);
  EXPECT_EQ(a.reference, b.reference);
  EXPECT_EQ(a.coupling_stiffness, b.coupling_stiffness);
  EXPECT_EQ(a.coupling_damping, b.coupling_damping);
  EXPECT_EQ(a.tool_mass, b.tool_mass);
  EXPECT_EQ(a.packet_interval, b.packet_interval);
  EXPECT_EQ(a.batch, b.batch);
  EXPECT_EQ(a.position_deadband, b.position_deadband);
  EXPECT_EQ(a.force_deadband, b.force_deadband);
  EXPECT_EQ(a.predictor, b.predictor);
  EXPECT_EQ(a.keep_alive, b.keep_alive);
  EXPECT_EQ(a.local_model, b.local_model);
}

JoinRequest request() {
  JoinRequest r{"someone", "room", {}, unusual_parameters()};
  r.device.name = "omega.7";
  r.device.translation_dof = 2;
  r.device.rotation_sensed = 3;
  r.device.rotation_actuated = 3;
  r.device.damping = 0.1;
  r.device.rotational_damping = 0.2;
  r.device.apparent_mass = 0.3;
  r.device.coulomb_friction = 0.4;
  r.device.position_resolution = 0.5;
  r.device.max_force = 0.6;
  r.device.continuous_force = 0.7;
  r.device.max_torque = 0.8;
  r.device.workspace = {0.9, 1.0, 1.1};
  r.role = Role::observer;
  r.aes_256_gcm = true;
  return r;
}

TEST(Control, JoinRequestRoundTrip) {
  const JoinRequest sent = request();
  const JoinRequest got = round_trip(sent);
  EXPECT_EQ(got.client, sent.client);
  EXPECT_EQ(got.scene, sent.scene);
  expect_same(got.parameters, sent.parameters);
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

/// FNV-1a of a frame.
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

// Who asks for no tool, and a scene of one, send the same bytes as if there were no such field.
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
  expect_same(joined.parameters, SessionParameters{});  // c1, c2 stay not given

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
  expect_same(set.parameters, unusual_parameters());
  const ParametersSet was_set = round_trip(ParametersSet{6, unusual_parameters()});
  EXPECT_EQ(was_set.session, 6u);
  expect_same(was_set.parameters, unusual_parameters());
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
  for (int code = 0; code <= static_cast<int>(RefusalCode::failed); ++code) {
    const Refused refused = round_trip(Refused{static_cast<RefusalCode>(code), "because"});
    EXPECT_EQ(static_cast<int>(refused.code), code);
    EXPECT_EQ(refused.reason, "because");
    EXPECT_STRNE(name(refused.code), "unknown");
  }
}

/// A reason may quote a whole file: no length of it makes a frame that cannot be sent.
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

/// Characters of 1 to 4 bytes, at every place of the cut: none is split.
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
  // Bytes that are no UTF-8 are cut anywhere, and not for ever.
  EXPECT_EQ(shortened(std::string(100, '\x80'), 18), std::string(12, '\x80') + " [...]");
}

TEST(Control, FrameLengthIsLittleEndian) {
  const std::array<std::uint8_t, 4> bytes = {0x04, 0x03, 0x02, 0x01};
  EXPECT_EQ(frame_length(bytes), 0x01020304u);
  const auto frame = encode(ListScenes{});
  EXPECT_EQ(frame[0], frame.size() - 4);
  EXPECT_EQ(frame[3], 0);
}

TEST(Control, LimitsOfNamesAndFrames) {
  JoinRequest r = request();
  r.client = std::string(kMaxName, 'x');
  EXPECT_TRUE(decode(body(encode(r))));
  r.client += 'x';
  EXPECT_FALSE(decode(body(encode(r))));
  JoinRequest longest_request = request();
  longest_request.client = std::string(kMaxFrame, 'x');
  EXPECT_THROW(encode(longest_request), std::length_error);
  const std::vector<std::uint8_t> large(kMaxFrame + 1);
  EXPECT_FALSE(decode(large));
  SceneList most;
  for (std::size_t i = 0; i < kMaxScenes; ++i)
    most.scenes.push_back({std::string(kMaxName, 'x'), 1, 1, 1});
  EXPECT_EQ(round_trip(most).scenes.size(), kMaxScenes);
  SessionList longest;
  for (std::size_t i = 0; i < kMaxSessionEntries; ++i)
    longest.sessions.push_back(
        {i + 1, std::string(kMaxName, 'x'), std::string(kMaxName, 'y'), Role::admin});
  EXPECT_EQ(round_trip(longest).sessions.size(), kMaxSessionEntries);
  EXPECT_FALSE(decode(body(encode(Authenticate{Secret(std::string(kMaxName + 1, 'x'))}))));
  // A token fits what strangers may send.
  EXPECT_LE(encode(Authenticate{Secret(std::string(kMaxName, 'x'))}).size(), kMaxFirstFrame);
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

/// FlatBuffers' verifier lets them through, and reading them is undefined.
TEST(Control, NumbersOutOfPlaceAreNoMessage) {
  JoinRequest sent = request();
  sent.device.damping = Vec3(1, 2, 3);
  const auto frame = encode(sent);
  const std::vector<std::uint8_t> bytes(body(frame).begin(), body(frame).end());
  const wire::DeviceSpec* device =
      wire::GetControlMessage(bytes.data())->body_as_JoinRequest()->device();
  const auto moved = test::with_misaligned_vector(
      bytes, bytes.data(), device, wire::DeviceSpec::VT_DAMPING_TENSOR, 3 * sizeof(double));
  flatbuffers::Verifier verifier(moved.data(), moved.size());
  ASSERT_TRUE(wire::VerifyControlMessageBuffer(verifier));
  EXPECT_TRUE(decode(bytes));
  EXPECT_FALSE(decode(moved));
}

/// Whether there is such a method is for the program to say: the message arrives, with its name.
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

TEST(Control, ChoicesThatAreNoneAreRefused) {
  SessionParameters p;
  for (const int which : {0, 1, 2, 3, 4}) {
    p = {};
    if (which == 0) p.mode = std::string(kLongestMethodName + 1, 'm');
    if (which == 1) p.projection = static_cast<Projection>(2);
    if (which == 2) p.side = static_cast<BoundingSide>(3);
    if (which == 3) p.reference = static_cast<PassivityReference>(2);
    if (which == 4) p.storage = static_cast<Storage>(2);
    EXPECT_FALSE(decode(body(encode(SetParameters{1, p})))) << which;
  }
  JoinRequest nobody = request();
  nobody.role = static_cast<Role>(3);
  EXPECT_FALSE(decode(body(encode(nobody))));
  for (const int suite : {0, 3}) {
    JoinAccepted sealed;
    sealed.suite = static_cast<CipherSuite>(suite);
    EXPECT_FALSE(decode(body(encode(sealed)))) << suite;
  }
  EXPECT_FALSE(decode(body(encode(Refused{static_cast<RefusalCode>(14), "x"}))));
}

/// A list may point at one entry ever so often: a small frame that would grow without end.
TEST(Control, ListThatMultipliesOneEntry) {
  flatbuffers::FlatBufferBuilder builder;
  const auto entry = wire::CreateSceneEntryDirect(builder, "again", 1, 1, 1);
  const std::vector<flatbuffers::Offset<wire::SceneEntry>> entries(10'000, entry);
  const auto list = wire::CreateSceneList(builder, builder.CreateVector(entries));
  builder.Finish(wire::CreateControlMessage(builder, wire::Body::SceneList, list.Union()));
  ASSERT_LT(builder.GetSize(), kMaxFrame);
  EXPECT_FALSE(decode({builder.GetBufferPointer(), builder.GetSize()}));
}

TEST(ControlFuzz, TruncationsAndFlipsAreHarmless) {
  std::mt19937_64 random(1);
  JoinRequest tool = request();
  tool.tool = "key";
  const std::vector<Message> messages = {request(),
                                         SceneList{{{"a", 1, 2, 3}, {"b", 4, 5, 6}}},
                                         SetParameters{5, unusual_parameters()},
                                         Refused{RefusalCode::full, "no"},
                                         JoinAccepted{},
                                         tool,
                                         Authenticate{Secret("fw_1")},
                                         SessionList{{{1, "a", "b", Role::admin}}, false}};
  int valid = 0;
  for (const Message& message : messages) {
    const auto frame = encode(message);
    const std::vector<std::uint8_t> bytes(body(frame).begin(), body(frame).end());
    for (std::size_t size = 0; size < bytes.size(); ++size)
      valid +=
          decode(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + static_cast<long>(size)))
              .has_value();
    for (int round = 0; round < 5000; ++round) {
      auto spoiled = bytes;
      for (std::size_t flips = 1 + random() % 6; flips > 0; --flips)
        spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
      valid += decode(spoiled).has_value();
    }
  }
  EXPECT_GT(valid, 0);  // some flips only change numbers: those are still messages
}

}  // namespace
}  // namespace feltwire::control
