// The closed forms of the advice, its adversaries, and the configuration files that it writes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "client/emulated_link/link.hpp"
#include "client/emulated_link/link_model.hpp"
#include "core/base/file_error.hpp"
#include "core/base/text.hpp"
#include "core/device/device_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/app/server_config.hpp"
#include "sim/studies/advise/advice.hpp"
#include "sim/studies/advise/advice_check.hpp"
#include "sim/studies/advise/advice_report.hpp"
#include "sim/studies/advise/link_of_report.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::advise::advise_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMillisecond = 1e-3;

Scene plane(double stiffness = 1000.0) {
  Object object{.name = "plane", .shape = Plane{}, .pose = {}, .material = {}};
  object.material.stiffness = stiffness;
  return Scene("plane", {object});
}

Question question(const char* link, const char* device = "simulated") {
  return {.device = builtin_device(device),
          .link = parse_link(link),
          .most_rate = 1000.0,
          .explains = false};
}

/// A machine of the tables, so that no test measures time.
constexpr MachineSpeed kMachine{
    .received = 0.3e-6, .replied = 0.1e-6, .tick = 0.4e-6, .datagram = 0.2e-6, .touch = 0.1e-6};

Advice advice_for(const Question& asked, const Scene& scene) {
  return advise(asked, scene, start_places(scene), kMachine);
}

// --- closed forms ---

TEST(AdviseLink, WithoutLossEachGapIsOneInterval) {
  const Gaps found = gaps({});
  EXPECT_DOUBLE_EQ(found.mean, 1.0);
  EXPECT_DOUBLE_EQ(found.square_over_mean, 1.0);
}

TEST(AdviseLink, IndependentLossesHaveGeometricGaps) {
  // With p = 1/2: E[G] = 2, E[G^2] = (2 - q)/q^2 = 6.
  const Gaps found = gaps({.share = 0.5, .run = 2.0});
  EXPECT_NEAR(found.mean, 2.0, 1e-12);
  EXPECT_NEAR(found.square_over_mean, 3.0, 1e-12);
}

TEST(AdviseLink, ACommandFadesInTheSecondHalfOfItsHoldTime) {
  EXPECT_NEAR(mean_fade({}, 0.05, 0.1), 1.0, 1e-12);
  EXPECT_NEAR(mean_fade({}, 0.1, 0.1), 0.75, 1e-12);
  EXPECT_NEAR(mean_fade({}, 0.2, 0.1), 0.375, 1e-12);
  EXPECT_DOUBLE_EQ(mean_fade({.share = 1.0, .run = 1.0}, 0.01, 0.1), 0.0);
  EXPECT_LT(mean_fade({.share = 0.3, .run = 5.0}, 0.05, 0.25),
            mean_fade({.share = 0.3, .run = 1.0 / 0.7}, 0.05, 0.25));
}

TEST(AdviseLink, NewsAreAsOldAsTheRoundTripAndHalfAnInterval) {
  const TwoWayLinkOptions none = parse_link("delay=0");
  const Flow each{1e-3, 200.0};
  // A link without delay answers the sample of one tick before the next.
  EXPECT_NEAR(news_age(none, each, each, 1e-3).total, 1e-3, 1e-12);
  const TwoWayLinkOptions far = parse_link("delay=25");
  EXPECT_NEAR(news_age(far, each, each, 1e-3).total, 50e-3, 1e-12);
  // At 100 Hz ages go from 50 to 59 ms.
  const Flow few{10e-3, 200.0};
  EXPECT_NEAR(news_age(far, few, few, 1e-3).total, 54.5e-3, 1e-12);
  // Replies only every 50 ms: 50 to 99 ms.
  EXPECT_NEAR(news_age(far, few, {50e-3, 200.0}, 1e-3).total, 74.5e-3, 1e-12);
  EXPECT_NEAR(news_age(far, few, few, 1e-3).added(), 4.5e-3, 1e-12);
}

TEST(AdviseLink, AThinLineTakesTimeForEachByte) {
  LinkOptions line;
  line.rate = 64e3;
  EXPECT_NEAR(mean_delay(line, {0.1, 80.0}), 10 * kMillisecond, 1e-12);
  // More than it takes: the whole queue is before each datagram.
  line.queue = 8000.0;
  EXPECT_NEAR(mean_delay(line, {5e-3, 80.0}), 1.0 + 10 * kMillisecond, 1e-9);
}

/// [s] the mean delay of datagrams through the emulator itself.
double emulated_delay(const LinkOptions& options, double interval) {
  OneWayLink link(options, 7, 4096);
  constexpr std::array<std::uint8_t, 100> kBytes{};
  constexpr int kDatagrams = 20'000;
  for (int n = 0; n < kDatagrams; ++n) {
    const Nanoseconds now = from_seconds(n * interval);
    link.enter(Bytes(kBytes.data(), kBytes.size()), now);
    for (auto due = link.next_due(); due && *due <= now; due = link.next_due()) link.leave(*due);
  }
  for (auto due = link.next_due(); due; due = link.next_due()) link.leave(*due);
  const LinkStatistics counted = link.statistics();
  return seconds(counted.total_delay) / static_cast<double>(counted.delivered);
}

TEST(AdviseLink, ALinkThatKeepsTheOrderDelaysAsTheEmulatorDoes) {
  for (const char* distribution : {"normal", "uniform", "pareto"})
    for (const double interval : {1e-3, 10e-3, 50e-3}) {
      const auto link = parse_link(std::string("delay=60,jitter=6,distribution=") + distribution);
      const double foretold = mean_delay(link.up, {interval, 128.0});
      EXPECT_NEAR(foretold, emulated_delay(link.up, interval), 0.02 * foretold)
          << distribution << ' ' << interval;
    }
}

TEST(AdviseTraffic, DatagramsHaveTheSizesOfTheProtocol) {
  // docs/network.md: a sample 144, with orientation 208; each repeated one 64 and 112 more.
  EXPECT_EQ(sample_datagram(1, false), 144u + kHeadersOnTheWire);
  EXPECT_EQ(sample_datagram(4, false), 144u + 3 * 64u + kHeadersOnTheWire);
  EXPECT_EQ(sample_datagram(1, true), 208u + kHeadersOnTheWire);
  EXPECT_EQ(sample_datagram(2, true), 208u + 112u + kHeadersOnTheWire);
}

TEST(AdviseTraffic, AStillHandGetsAnAnswerAKeepAlive) {
  const TwoWayLinkOptions link = parse_link("delay=25");
  const DeviceSpec& device = builtin_device("simulated");
  const Setting wan{.profile = "wan"}, thin{.profile = "thin"};
  EXPECT_NEAR(traffic_of(wan.parameters(), device, link, 300, false).down.interval, 50e-3, 1e-12);
  EXPECT_NEAR(traffic_of(thin.parameters(), device, link, 300, false).down.interval, 0.16, 1e-12);
  // A hand that moves gets an answer to each datagram.
  EXPECT_NEAR(traffic_of(wan.parameters(), device, link, 300, true).down.interval, 10e-3, 1e-12);
}

TEST(AdviseFeel, TheDampingAloneShowsTwoBOverTAndTwoL) {
  DeviceSpec device = builtin_device("simulated");
  device.damping = 0.5;
  device.actuation.lag = 0.0;
  EXPECT_NEAR(damping_limit(device, 1e-3), 1000.0, 1e-9);
  device.actuation.lag = 0.3e-3;
  EXPECT_NEAR(damping_limit(device, 1e-3), 1.0 / 1.6e-3, 1e-9);
  device.actuation.lag = 0.0;
  device.actuation.late_ticks = 1;
  EXPECT_NEAR(damping_limit(device, 1e-3), 1.0 / 3e-3, 1e-9);
  device.actuation.late_ticks = 0;
  device.damping = Vec3(0.5, 0.25, 1.0);  // the least direction counts
  EXPECT_NEAR(damping_limit(device, 1e-3), 500.0, 1e-9);
}

TEST(AdviseFeel, AWallBehindATransmissionIsTwoSpringsInARow) {
  EXPECT_DOUBLE_EQ(in_series(3000.0, 0.0), 3000.0);
  EXPECT_DOUBLE_EQ(in_series(3000.0, 3000.0), 1500.0);
  DeviceSpec device = builtin_device("simulated");
  device.damping = 5.0;
  device.transmission.stiffness = 3000.0;
  const Felt felt = felt_of(device, {.law = "contact_frame"}, 3000.0, 0.5);
  EXPECT_DOUBLE_EQ(felt.felt, 750.0);  // half of it fades
}

TEST(AdviseFeel, TheLimitIsThePartThatGivesTheMost) {
  DeviceSpec device = builtin_device("simulated");
  device.damping = 0.1;
  device.actuation.lag = 0.0;
  device.transmission.stiffness = 0.0;
  const Felt soft = explained(device, {.law = "contact_frame"}, 40e3, 1.0, 1000.0);
  EXPECT_EQ(soft.limit, Limit::damping);
  ASSERT_FALSE(soft.purchases.empty());
  EXPECT_NEAR(soft.purchases.front().felt, 2.0 * soft.felt, 1e-9);
  device.damping = 500.0;
  device.transmission.stiffness = 3000.0;
  EXPECT_EQ(explained(device, {.law = "contact_frame"}, 40e3, 1.0, 1000.0).limit,
            Limit::transmission);
  device.transmission.stiffness = 0.0;
  EXPECT_EQ(explained(device, {.law = "contact_frame"}, 40e3, 1.0, 1000.0).limit, Limit::nothing);
}

// --- the choice ---

TEST(Advise, AFarLinkGetsALocalModelAndFewDatagrams) {
  const Advice advice = advice_for(question("delay=25,jitter=2"), plane());
  EXPECT_EQ(advice.setting.profile, "wan");
  EXPECT_TRUE(advice.setting.local_model);
  ASSERT_EQ(advice.feel.size(), 1u);
  EXPECT_GT(advice.feel.front().share(), 0.9);
  EXPECT_LT(advice.up.value, 300.0);
  EXPECT_EQ(advice.cores_needed, 1);
}

TEST(Advise, AThinLineGetsThinTraffic) {
  EXPECT_EQ(advice_for(question("delay=40,rate=0.064"), plane()).setting.profile, "thin");
  const Advice none = advice_for(question("delay=40,rate=0.002"), plane());
  EXPECT_EQ(none.limit, Limit::line);
  EXPECT_FALSE(none.remedies.empty());
}

TEST(Advise, ManyHandsNeedMoreCoresAndSayWhy) {
  Question asked = question("delay=25");
  asked.hands = 100'000;
  const Advice advice = advice_for(asked, plane());
  EXPECT_GT(advice.cores_needed, 1);
  EXPECT_EQ(advice.limit, Limit::cpu);
}

// --- adversaries ---

TEST(AdviseAdversary, NoHandsCoresOrRateAreRefusedByName) {
  const auto with = [](const auto& change) {
    Question asked = question("lan");
    change(asked);
    return [asked] { advice_for(asked, plane()); };
  };
  for (const int wrong : {0, -3, 2'000'000})
    EXPECT_THAT(with([&](Question& q) { q.hands = wrong; }),
                ThrowsMessage<std::invalid_argument>(HasSubstr("--hands")));
  for (const int wrong : {0, -1, 1 << 20})
    EXPECT_THAT(with([&](Question& q) { q.cores = wrong; }),
                ThrowsMessage<std::invalid_argument>(HasSubstr("--cores")));
  for (const double wrong : {kNan, 0.0, -5.0, 1e9, HUGE_VAL})
    EXPECT_THAT(with([&](Question& q) { q.most_rate = wrong; }),
                ThrowsMessage<std::invalid_argument>(HasSubstr("--most-rate")));
}

TEST(AdviseAdversary, ADeviceWithImpossibleNumbersIsRefusedByField) {
  const auto with = [](const auto& change) {
    Question asked = question("lan");
    change(asked.device);
    return [asked] { advice_for(asked, plane()); };
  };
  EXPECT_THAT(with([](DeviceSpec& d) { d.damping = kNan; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("damping")));
  EXPECT_THAT(with([](DeviceSpec& d) { d.position_resolution = -1e-6; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("position_resolution")));
  EXPECT_THROW(device_spec("no_such_device"), std::invalid_argument);
  EXPECT_THROW(device_spec("/nowhere/device.json"), FileError);
}

TEST(AdviseAdversary, ADeviceWithoutDampingAndMassStillGetsAnAnswer) {
  Question asked = question("lan");
  asked.device.damping = 0.0;
  asked.device.least_mass = asked.device.least_friction = 0.0;
  const Advice advice = advice_for(asked, plane());
  for (const Felt& felt : advice.feel) {
    EXPECT_TRUE(std::isfinite(felt.felt));
    EXPECT_GE(felt.felt, 0.0);
    EXPECT_LE(felt.felt, felt.wall);
  }
}

TEST(AdviseAdversary, ASceneThatDoesNotExistIsNamed) {
  EXPECT_THAT([] { load_scene("/nowhere/scene.json"); },
              ThrowsMessage<FileError>(HasSubstr("/nowhere/scene.json")));
}

TEST(AdviseAdversary, AServerIsMeasuredByTheClient) {
  EXPECT_THAT([] { link_of("localhost:6720"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--report run.json")));
  EXPECT_THROW(link_of("no such link"), std::invalid_argument);
  EXPECT_DOUBLE_EQ(link_of("delay=10").up.delay, 10 * kMillisecond);
}

TEST(AdviseAdversary, AReportWithoutALinkIsRefusedByMember) {
  const test::TemporaryFolder folder;
  const auto report = [&](const std::string& text) {
    const std::filesystem::path file = folder / "run.json";
    write_text(file, text);
    return file;
  };
  const TwoWayLinkOptions link = link_of_report(report(
      R"({"server_clock": {"delay_up_us": 2e3, "delay_down_us": 3e3, "jitter_up_us": 100,
          "jitter_down_us": 200}, "sample_datagrams": 1000, "lost": 190})"));
  EXPECT_NEAR(link.up.delay, 2e-3, 1e-12);
  EXPECT_NEAR(link.down.jitter, 2e-4, 1e-12);
  EXPECT_NEAR(link.up.loss, 0.1, 1e-12);  // 0.9 of 0.9 come through
  for (const char* wrong :
       {"", "[]", "{}", R"({"server_clock": null})",
        R"({"server_clock": {"delay_up_us": -1}, "sample_datagrams": 1, "lost": 0})",
        R"({"server_clock": {"delay_up_us": 1, "delay_down_us": 1, "jitter_up_us": 0,
            "jitter_down_us": 0}, "sample_datagrams": 0, "lost": 0})"})
    EXPECT_THAT([&] { link_of_report(report(wrong)); },
                ThrowsMessage<FileError>(HasSubstr("run.json")))
        << wrong;
}

// --- files ---

TEST(AdviseFiles, ServerAndClientLoadTheConfigurationsThatItWrites) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scene =
      std::filesystem::path(FELTWIRE_SOURCE_DIR) / "scenes/room.json";
  const Sources sources{"phantom_premium_1.5", scene};
  ::setenv("FELTWIRE_TOKEN", "fw_of_a_test", 1);
  for (const char* link : {"lan", "transatlantic", "delay=40,rate=0.064"}) {
    Question asked = question(link, "phantom_premium_1.5");
    asked.hands = 5;
    const Advice advice = advice_for(asked, load_scene(scene));
    write_text(folder / "client.json", client_config(sources, advice));
    write_text(folder / "server.json", server_config(asked, sources, advice));

    const ServerConfig server = load_config(folder / "server.json");
    EXPECT_EQ(server.scenes, std::vector{scene});
    EXPECT_GE(server.max_sessions_per_scene, 5);
    EXPECT_NO_THROW(validate(server));

    // The program has read its options when it finds no server at that port.
    const auto client = [&](const std::string& config) {
      return test::Program(FELTWIRE_CLIENT_PROGRAM,
                           {"--connect", "127.0.0.1:1", "--scene", "room", "--fingerprint",
                            std::string(64, 'a'), "--config", (folder / config).string()})
          .finish();
    };
    const test::Outcome loaded = client("client.json");
    EXPECT_EQ(loaded.status, 1) << loaded.error;
    EXPECT_THAT(loaded.error, HasSubstr("127.0.0.1:1"));
    write_text(folder / "wrong.json", R"({"rate": 0})");
    EXPECT_EQ(client("wrong.json").status, 2);
  }
}

// --- the check ---

TEST(AdviseCheck, TheSameSeedDrawsTheSameCase) {
  const DrawnCase one = drawn_case(5), again = drawn_case(5), other = drawn_case(6);
  EXPECT_EQ(one.link, again.link);
  EXPECT_EQ(one.device.damping, again.device.damping);
  EXPECT_EQ(one.places.size(), again.places.size());
  EXPECT_NE(one.link, other.link);
}

TEST(AdviseCheck, EveryDrawnCaseIsPossible) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const DrawnCase drawn = drawn_case(seed);
    EXPECT_NO_THROW(validate(drawn.device)) << seed;
    EXPECT_NO_THROW(parse_link(drawn.link)) << drawn.link;
    ASSERT_FALSE(drawn.places.empty());
    // Each place lies on its surface: a tool just below it is pushed out along the normal.
    for (const Place& place : drawn.places) {
      TouchMemory memory = drawn.scene.memory();
      constexpr double kDepth = 1e-4;
      const Command command =
          drawn.scene.touch(Tool{place.point - kDepth * place.normal, Vec3::Zero()}, memory);
      EXPECT_NEAR(command.elastic.dot(place.normal), kDepth * place.material.stiffness,
                  1e-2 * kDepth * place.material.stiffness)
          << seed << ' ' << place.object;
    }
  }
}

TEST(AdviseCheck, AllSettingsOfTheSearchArePossible) {
  for (const Setting& setting : all_settings())
    EXPECT_NO_THROW(setting.parameters()) << setting.mode_option();
}

TEST(AdviseCheck, TheErrorIsRelativeToTheMeasurement) {
  EXPECT_DOUBLE_EQ((Compared{.predicted = 0.0, .measured = 0.0}).error(), 0.0);
  EXPECT_DOUBLE_EQ((Compared{.predicted = 110.0, .measured = 100.0}).error(), 0.1);
  EXPECT_GT((Compared{.predicted = 1.0, .measured = 0.0}).error(), 1e6);
  EXPECT_THROW(check_advice({.cases = 1}), std::invalid_argument);
  EXPECT_THROW(check_advice({.cases = 4, .searched = 3}), std::invalid_argument);
}

TEST(AdviseCheck, TrafficAndAgeOfAFewCasesAreAsForetold) {
  const auto cases = check_advice({.seed = 7, .cases = 4, .searched = 0});
  ASSERT_EQ(cases.size(), 4u);
  constexpr double kWorst = 0.3;  // the bar of docs/lab/advise.md
  for (const CheckedCase& c : cases) {
    EXPECT_TRUE(c.passive) << c.seed;
    EXPECT_LT(c.news_age.error(), kWorst) << c.seed;
    EXPECT_LT(c.up.error(), kWorst) << c.seed;
    EXPECT_LT(c.down.error(), kWorst) << c.seed;
  }
}

}  // namespace
}  // namespace feltwire::advise::advise_test
