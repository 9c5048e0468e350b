#include "client/run/report.hpp"

#include <gmock/gmock.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/emulated_link/link_json.hpp"
#include "core/build_info/build_info.hpp"

namespace feltwire::report_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Returns a servo with three samples. Two of them were answered.
std::unique_ptr<Servo> used_servo() {
  SessionParameters p;
  p.mode = "none";
  auto servo = std::make_unique<Servo>(builtin_device("simulated"), p);
  Nanoseconds now{0};
  for (std::uint64_t i = 1; i <= 3; ++i) {
    now += std::chrono::milliseconds(1);
    servo->render(
        {.pose = {.position = Vec3(0, 0, 0.01 * static_cast<double>(i))}, .jumped = false}, now);
    servo->hold({.elastic = Vec3(0, 0, 2)});
    servo->sent();
    Reply reply;
    reply.sample_index = i;
    reply.command.elastic = Vec3(0, 0, 2);
    reply.delivered.elastic = 0.5;
    if (i != 2)
      // round trips of 100 us and 2.7 ms
      servo->take(reply, now + std::chrono::microseconds(100 * i * i * i));
  }
  return servo;
}

json report(const Servo& servo, const LoopResult& result = {}, const std::string& client = "anna",
            double scene_stiffness = 0.0) {
  TransportStatistics transport;
  transport.sent = 6;
  transport.dropped[static_cast<std::size_t>(DropReason::malformed)] = 4;
  return json::parse(
      report_json({client, "wall", "localhost:6720", "simulated", {}, scene_stiffness}, servo,
                  transport, result));
}

TEST(Report, NamesTheFlightRecords) {
  const auto servo = used_servo();
  EXPECT_EQ(report(*servo)["flight_records"], json::array());
  const std::vector<WrittenFlight> written = {{"flights/a.mcap", "the session was lost"},
                                              {"flights/b.mcap", "asked for"}};
  RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  run.flight_records = &written;
  EXPECT_EQ(json::parse(report_json(run, *servo, {}, {}))["flight_records"],
            json::parse(R"([{"file": "flights/a.mcap", "cause": "the session was lost"},
                            {"file": "flights/b.mcap", "cause": "asked for"}])"));
}

/// The report contains the energy at the true ports of a simulated device.
TEST(Report, HasTheTrueEnergyOfASimulatedDevice) {
  const auto servo = used_servo();
  EXPECT_TRUE(report(*servo)["true_energy"].is_null());
  RunDescription run{"anna", "wall", "localhost:6720", "simulated:plant=a.json", {}};
  run.true_energy = TrueEnergy{.given = 0.5, .burned = 0.25, .made = 0.375, .to_hand = 0.125};
  EXPECT_EQ(json::parse(report_json(run, *servo, {}, {}))["true_energy"],
            json::parse(R"({"given_j": 0.5, "burned_j": 0.25, "made_j": 0.375,
                            "to_hand_j": 0.125})"));
}

/// The report contains the time until the stall detector releases the device, and the blocked call.
TEST(Report, SaysWhenTheDeviceIsLetGo) {
  const auto servo = used_servo();
  LoopResult result;
  result.let_go_after = 5e-3;
  EXPECT_EQ(report(*servo, result)["let_go"],
            json::parse(R"({"after_s": 0.005, "still_s": null, "in": null})"));
  result.stood_still = true;
  result.still_for = 5.25e-3;
  result.still_in = DeviceCall::read;
  EXPECT_EQ(report(*servo, result)["let_go"],
            json::parse(R"({"after_s": 0.005, "still_s": 0.00525, "in": "read"})"));
}

TEST(Report, SaysThatContactTakesTooLong) {
  SessionParameters p;
  p.local_model = true;
  Servo servo(builtin_device("simulated"), p);
  RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  json model = json::parse(report_json(run, servo, {}, {}))["local_model"];
  EXPECT_TRUE(model["contact_refused"].is_null());
  EXPECT_EQ(model["contact_cut_samples"], 0);
  EXPECT_TRUE(model["allowed_contact_work"].is_null());
  FetchedScene scene;
  scene.most_work = 4321;
  servo.use(&scene);
  run.contact_refused = "near object 3 it takes too long";
  model = json::parse(report_json(run, servo, {}, {}))["local_model"];
  EXPECT_EQ(model["contact_refused"], "near object 3 it takes too long");
  EXPECT_EQ(model["allowed_contact_work"], 4321);
}

TEST(Report, SaysWhatTheHandHeld) {
  const auto servo = used_servo();
  EXPECT_TRUE(report(*servo)["tool"].is_null());
  RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  run.tool = "key";
  EXPECT_EQ(json::parse(report_json(run, *servo, {}, {}))["tool"], "key");
}

/// A hand jumps while its device reports no jump. The energy account must count a hand of excess
/// strength. A hand that oscillates on a wall must get less credited damping.
TEST(Report, SaysWhatAccountAndShapingSaw) {
  SessionParameters p;
  p.mode = "shaped";
  p.local_model = true;
  Servo servo(builtin_device("simulated"), p);
  Nanoseconds now{0};
  for (std::uint64_t i = 1; i <= 60; ++i) {
    now += std::chrono::milliseconds(1);
    const double height = 0.01 * static_cast<double>(i % 4 < 2 ? 0 : 1);
    servo.render({.pose = {.position = Vec3(0, 0, height)}, .jumped = false}, now);
    servo.hold({.elastic = Vec3(0, 0, 2)});
    servo.sent();
    Reply reply;
    reply.sample_index = i;
    reply.command.elastic = Vec3(0, 0, 2);
    servo.take(reply, now + std::chrono::microseconds(100));
  }
  const json written = report(servo);
  ASSERT_TRUE(servo.account());
  EXPECT_GT(servo.account()->statistics().strong_hand, 0u);
  EXPECT_EQ(written["account"]["strong_hand_samples"], servo.account()->statistics().strong_hand);
  ASSERT_TRUE(servo.hand_credit());
  EXPECT_GT(servo.hand_credit()->steps_down, 0u);
  EXPECT_EQ(written["hand_credit"]["steps_down"], servo.hand_credit()->steps_down);
  EXPECT_LT(written["hand_credit"]["damping_n_s_per_m"], BoundingConfig{}.hand_damping);
  EXPECT_EQ(written["hand_credit"]["near_share"], 1.0) << "none of its forces was made here";
  EXPECT_EQ(written["hand_credit"]["near_steps_down"], 0);
  EXPECT_EQ(written["hand_credit"]["untold_lag_s"], 0.0);
  EXPECT_EQ(written["local_model"]["hand_overs"], servo.statistics().local_model.hand_overs);
}

/// The report contains each change of state between the hand and its robot, with its time.
TEST(Report, SaysTheStatesOfTheRobot) {
  SessionParameters p;
  p.local_model = true;
  ServoOptions options;
  options.leads = RemoteTrust{};
  Servo servo(builtin_device("simulated"), p, options);
  EXPECT_TRUE(report(*used_servo())["robot"].is_null());
  const std::array<LinkState, 6> states = {LinkState::ready,   LinkState::ready, LinkState::engaged,
                                           LinkState::engaged, LinkState::hold,  LinkState::ready};
  Nanoseconds now{0};
  for (std::size_t i = 0; i < states.size(); ++i) {
    now += std::chrono::milliseconds(100);
    servo.render({}, now);
    servo.hold({});
    servo.sent();
    Reply reply;
    reply.sample_index = i + 1;
    reply.modelled = true;
    reply.remote.emplace().state = states.at(i);
    servo.take(reply, now);
  }
  const json changes = report(servo)["robot"]["changes"];
  ASSERT_EQ(changes.size(), 4u);
  EXPECT_EQ(changes[0]["state"], "ready");
  EXPECT_EQ(changes[0]["time_s"], 0.0);
  EXPECT_EQ(changes[1]["state"], "engaged");
  EXPECT_NEAR(changes[1]["time_s"], 0.2, 1e-9);
  EXPECT_EQ(changes[2]["state"], "hold");
  EXPECT_EQ(changes[3]["state"], "ready");
  EXPECT_NEAR(changes[3]["time_s"], 0.5, 1e-9);
  EXPECT_EQ(report(servo)["robot"]["left_out"], 0);
}

TEST(LinkStates, KeepsTheFirstChangesAndCountsTheOthers) {
  LinkStates states;
  for (std::size_t i = 0; i < LinkStates::kMost + 7; ++i)
    states.take(i % 2 == 0 ? LinkState::ready : LinkState::engaged, 1, Nanoseconds(i));
  EXPECT_EQ(states.changes().size(), LinkStates::kMost);
  EXPECT_EQ(states.left_out(), 7u);
  EXPECT_EQ(states.changes()[0].state, LinkState::ready);
  // A state of another robot is a change, even if the state is equal.
  LinkStates seats;
  seats.take(LinkState::ready, 0, Nanoseconds(0));
  seats.take(LinkState::ready, 1, Nanoseconds(1));
  EXPECT_EQ(seats.changes().size(), 2u);
}

TEST(Report, TakesWhateverTheUsersOwnPortSays) {
  const auto servo = used_servo();
  const RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  const auto link = [&](const std::string& said) {
    return json::parse(report_json(run, *servo, {}, {}, said))["link"];
  };
  EXPECT_TRUE(link("").is_null());
  EXPECT_EQ(link(R"({"lost": 3})")["lost"], 3);
  EXPECT_EQ(link("{not JSON"), "{not JSON");
  EXPECT_EQ(link("no \x1b[31mUTF-8 \xff"), "no \\x1b[31mUTF-8 \\xff");
}

TEST(Report, SaysBothVersions) {
  const auto servo = used_servo();
  RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  EXPECT_TRUE(json::parse(report_json(run, *servo, {}, {}))["server_version"].is_null());
  run.server_version = "0.1.0 4d7d03fe1c52";
  const json r = json::parse(report_json(run, *servo, {}, {}));
  EXPECT_EQ(r["server_version"], "0.1.0 4d7d03fe1c52");
  EXPECT_EQ(r["feltwire"]["version"], version());
}

TEST(Report, SaysWhatAnObserverSaw) {
  const auto servo = used_servo();
  EXPECT_EQ(report(*servo)["role"], "operator");
  EXPECT_TRUE(report(*servo)["view"].is_null());
  RunDescription run{"anna", "wall", "localhost:6720", "simulated", {}};
  run.sight = SightCounts{
      .views = 7, .hands = 1, .bodies = 2, .most_hands = 3, .most_bodies = 4, .left_out = 6};
  LoopResult result;
  result.views_dropped = 5;
  const json r = json::parse(report_json(run, *servo, {}, result));
  EXPECT_EQ(r["role"], "observer");
  EXPECT_EQ(r["view"], json({{"views", 7},
                             {"views_dropped", 5},
                             {"hands", 1},
                             {"bodies", 2},
                             {"most_hands", 3},
                             {"most_bodies", 4},
                             {"robots", json::array()},
                             {"left_out", 6}}));
  run.sight->robots = {LinkState::engaged};
  EXPECT_EQ(json::parse(report_json(run, *servo, {}, result))["view"]["robots"],
            json::array({"engaged"}));
}

TEST(Report, HoldsWhatWasCounted) {
  const auto servo = used_servo();
  LoopResult result;
  result.end = EndReason::requested;
  result.duration = 0.003;
  result.overruns = 1;
  for (int i = 1; i <= 100; ++i) result.wakeup_late.record(i * 1000);
  const json r = report(*servo, result);
  EXPECT_EQ(r["client"], "anna");
  EXPECT_EQ(r["scene"], "wall");
  EXPECT_EQ(r["device"]["kind"], "simulated");
  EXPECT_EQ(r["end"], "requested");
  EXPECT_EQ(r["duration_s"], 0.003);
  EXPECT_EQ(r["samples"], 3);
  EXPECT_EQ(r["answered"], 2);
  EXPECT_EQ(r["sample_datagrams"], 3);
  EXPECT_EQ(r["withheld"], 0);
  EXPECT_EQ(r["lost"], 1);
  EXPECT_EQ(r["late"], 1);
  EXPECT_NEAR(r["round_trip_us"]["p50"].get<double>(), 100.0, 0.5);
  EXPECT_EQ(r["round_trip_us"]["max"], 2700.0);
  EXPECT_NEAR(r["energy_delivered_j"]["elastic"].get<double>(), 0.04, 1e-12);
  EXPECT_EQ(r["energy_delivered_j"]["torque"], 0.0);
  EXPECT_EQ(r["bound_violations"], servo->port().violations());
  EXPECT_EQ(r["max_force_n"], 2.0);
  EXPECT_EQ(r["direction_error_deg"]["mean"], 0.0);
  EXPECT_NEAR(r["servo_wakeup_late_us"]["p99"].get<double>(), 99.0, 0.4);
  EXPECT_EQ(r["overruns"], 1);
  EXPECT_EQ(r["dropped"]["malformed"], 4);
  EXPECT_EQ(r["parameters"]["mode"], "none");
  EXPECT_EQ(r["parameters"]["side"], "client");
  // The client itself counts the violations.
  EXPECT_FALSE(r["server_last_reply"].contains("bound_violations"));
  EXPECT_EQ(r["server_last_reply"]["energy_delivered_j"]["elastic"], 0.5);
}

TEST(Report, TellsWhatAnEmulatedLinkDid) {
  const auto servo = used_servo();
  TwoWayLink link(parse_link("delay=20,down.loss=100,seed=6"), 0, 4);
  const std::vector<std::uint8_t> datagram(10);
  for (OneWayLink* one : {&link.up, &link.down}) {
    one->enter(datagram, std::chrono::milliseconds(1));
    one->enter(datagram, std::chrono::milliseconds(2));
    one->leave(std::chrono::milliseconds(21));
  }
  const json r = json::parse(report_json({"anna", "wall", "localhost:6720", "simulated", {}},
                                         *servo, {}, {}, link_json(link).dump()))["link"];
  EXPECT_EQ(r["given"], "delay=20,down.loss=100,seed=6");
  EXPECT_EQ(r["seed"], 6);
  EXPECT_DOUBLE_EQ(r["up"]["delay_ms"], 20.0);
  EXPECT_EQ(r["up"]["entered"], 2);
  EXPECT_EQ(r["up"]["delivered"], 1);
  EXPECT_EQ(r["up"]["in_flight"], 1);
  EXPECT_EQ(r["up"]["measured_delay_ms"]["mean"], 20.0);
  EXPECT_TRUE(r["up"]["trace"].is_null());
  EXPECT_EQ(r["down"]["lost"], 2);
  EXPECT_EQ(r["down"]["loss_percent"], 100.0);
  EXPECT_TRUE(r["down"]["measured_delay_ms"]["min"].is_null());
  EXPECT_TRUE(report(*servo)["link"].is_null());
}

TEST(Report, TellsWhereTheForceCameFrom) {
  EXPECT_EQ(report(*used_servo())["local_model"], nullptr);
  SessionParameters p;
  p.local_model = true;
  Servo servo(builtin_device("simulated"), p);
  Nanoseconds now{0};
  for (std::uint64_t i = 1; i <= 5; ++i) {
    now += std::chrono::milliseconds(1);
    servo.render({.pose = {.position = Vec3(0.02 * static_cast<double>(i), 0, 0)}, .jumped = false},
                 now);
    servo.hold({});
    if (i != 1) continue;
    Reply reply;
    reply.sample_index = 1;
    reply.modelled = true;
    reply.model.center = Vec3(0.02, 0, 0);
    reply.model.reach = 0.05;
    reply.model.count = 2;
    servo.take(reply, now);
  }
  const json r = report(servo);
  EXPECT_EQ(r["parameters"]["local_model"], true);
  EXPECT_EQ(r["local_model"]["models"], 1);
  EXPECT_EQ(r["local_model"]["mean_patches"], 2.0);
  EXPECT_EQ(r["local_model"]["samples_from_model"], 1);    // at 20 mm
  EXPECT_EQ(r["local_model"]["samples_from_both"], 1);     // at 40 mm
  EXPECT_EQ(r["local_model"]["samples_beyond_reach"], 2);  // at 60 and 80 mm
}

TEST(Report, CountsHowOftenWhatMovesWasPutBack) {
  Servo servo(builtin_device("simulated"), {});
  Nanoseconds now{0};
  const auto hear = [&](std::uint64_t index, bool recovering) {
    Reply reply;
    reply.sample_index = index;
    reply.recovering = recovering;
    servo.take(reply, now);
  };
  for (int i = 0; i < 8; ++i) {
    now += std::chrono::milliseconds(1);
    servo.hold(servo.render({}, now));
  }
  EXPECT_EQ(report(servo)["scene_resets"], 0);
  hear(1, false);
  hear(3, true);
  hear(2, false);  // The report must ignore a reordered reply.
  hear(4, true);
  EXPECT_EQ(report(servo)["scene_resets"], 1);
  EXPECT_EQ(report(servo)["server_last_reply"]["recovering"], true);
  hear(5, false);
  hear(6, true);
  hear(7, false);
  EXPECT_EQ(report(servo)["scene_resets"], 2);
  EXPECT_EQ(report(servo)["server_last_reply"]["recovering"], false);
}

TEST(Report, WhatThereIsNoNumberForIsNull) {
  const Servo idle(builtin_device("simulated"), {});
  const json r = report(idle);
  EXPECT_TRUE(r["round_trip_us"]["p50"].is_null());
  EXPECT_TRUE(r["direction_error_deg"]["p99"].is_null());
  EXPECT_TRUE(r["server_last_reply"].is_null());
  EXPECT_EQ(r["samples"], 0);
}

TEST(Report, SaysWhyThereWasNoForceAndHowItFelt) {
  const json some = report(*used_servo());
  EXPECT_TRUE(some["no_force"]["run"].is_null());
  EXPECT_EQ(some["no_force"]["samples"]["no_reply"], 0);  // A force was held in each sample.
  EXPECT_TRUE(some["oscillation_um"].is_null());
  EXPECT_TRUE(some["displayed_stiffness_n_per_m"].is_null());
  Servo idle(builtin_device("simulated"), {});
  for (int i = 1; i <= 5; ++i) {
    idle.render({}, std::chrono::milliseconds(i));
    idle.hold({});
  }
  EXPECT_EQ(report(idle)["no_force"]["run"], "no_reply");
  EXPECT_EQ(report(idle)["no_force"]["samples"]["no_reply"], 5);
  EXPECT_EQ(report(idle)["no_force"]["samples"]["waiting"], 0);
}

TEST(Report, StaysJsonWhateverItIsTold) {
  const auto servo = used_servo();
  LoopResult result;
  result.duration = std::numeric_limits<double>::infinity();
  const json r = report(*servo, result, "a\"b\\c\n\xff\xfe");
  EXPECT_TRUE(r["duration_s"].is_null());
  EXPECT_THAT(r["client"].get<std::string>(), HasSubstr("a\"b\\c\n"));
}

TEST(Report, SaysWhatTheSafetyStageDid) {
  SessionParameters p;
  p.mode = "none";
  Servo servo(builtin_device("simulated"), p,
              {.safety = {.force = {.max = 1.0, .slew = 400.0, .small = 0.1}, .ramp_up = 0.0}});
  Nanoseconds now{0};
  // The servo waits twice, until the scene's force is small. The force then rises by 0.4, 0.8, 1.0
  // N.
  for (const double newtons : {3.0, 3.0, 0.0, 3.0, 3.0, 3.0, 3.0}) {
    now += std::chrono::milliseconds(1);
    servo.hold(servo.render({}, now));
    Reply reply;
    reply.sample_index = servo.sample().index;
    reply.command.elastic = Vec3(0, 0, newtons);
    servo.take(reply, now);
  }
  const json r = report(servo);
  EXPECT_EQ(r["waiting_samples"], 2);
  EXPECT_EQ(r["slewed_samples"], 3);
  EXPECT_EQ(r["force_limited_samples"], 3);
  EXPECT_EQ(r["ramped_samples"], 0);
  EXPECT_EQ(r["too_fast_samples"], 0);
  EXPECT_EQ(r["max_force_n"], 1.0);
  const json expected = {{"max_force_n", 1.0},
                         {"velocity_limit_m_per_s", nullptr},
                         {"slew_n_per_s", 400.0},
                         {"ramp_up_s", 0.0},
                         {"wait_for_small_force_n", 0.1}};
  EXPECT_EQ(r["safety"], expected);
}

TEST(Report, WarnsOfScenesThatTheEncodersDoNotStand) {
  // quantum 23 um, f_c 0.1 N: 2 f_c / quantum = 8696 N/m
  const Servo servo(builtin_device("simulated"), {});
  const json stood = report(servo, {}, "anna", 8695.0)["encoder"];
  EXPECT_EQ(stood["quantum_m"], 23e-6);
  EXPECT_EQ(stood["coulomb_friction_n"], 0.1);
  EXPECT_NEAR(stood["stiffness_limit_n_per_m"].get<double>(), 0.2 / 23e-6, 1e-9);
  EXPECT_EQ(stood["scene_stiffness_n_per_m"], 8695.0);
  EXPECT_TRUE(stood["warning"].is_null());
  const json too_stiff = report(servo, {}, "anna", 8697.0)["encoder"];
  for (const char* said : {"8697 N/m", "8695.65 N/m", "0.1 N", "23 um", "simulated", "soften"})
    EXPECT_THAT(too_stiff["warning"].get<std::string>(), HasSubstr(said));
  // no scene stiffness given
  EXPECT_TRUE(report(servo)["encoder"]["scene_stiffness_n_per_m"].is_null());

  DeviceSpec exact = builtin_device("simulated");
  exact.position_resolution = 0.0;
  const json none = report(Servo(exact, {}), {}, "anna", 1e6)["encoder"];
  EXPECT_TRUE(none["quantum_m"].is_null());
  EXPECT_TRUE(none["stiffness_limit_n_per_m"].is_null());
  EXPECT_TRUE(none["warning"].is_null());
  DeviceSpec frictionless = builtin_device("simulated");
  frictionless.coulomb_friction = 0.0;
  EXPECT_TRUE(report(Servo(frictionless, {}), {}, "anna", 1.0)["encoder"]["warning"].is_string());
}

}  // namespace
}  // namespace feltwire::report_test
