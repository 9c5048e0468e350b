// The C interface, against a server of this process.

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "client/c_api/caller_device.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/offsets.h"
#include "core/base/latest_value.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/client/c_api/heap_uses.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_test {
namespace {

using ::testing::HasSubstr;

class CApi : public ::testing::Test, protected ApiServer {
 protected:
  fw_hand_options options() const { return hand_options(); }

  /// The program is the device, and is felt at once. Its thread may wait on a busy machine.
  fw_hand_options caller_options() const {
    static constexpr std::array<const char*, 6> kMoreOfCaller = {
        "--flight-recorder", "off", "--let-go-after", "1", "--hold-time", "1"};
    fw_hand_options given = options();
    given.device = "caller:await_still=0";
    given.stale_after = 0.2;
    given.more = kMoreOfCaller.data();
    given.more_count = static_cast<std::uint32_t>(kMoreOfCaller.size());
    return given;
  }

  static fw_pose at(double z) {
    fw_pose pose;
    fw_pose_default(&pose, sizeof pose);
    pose.position[2] = z;
    return pose;
  }

  /// Moves the hand on a straight line, a step for each tick of its servo.
  static void move(fw_hand* hand, double from, double to) {
    constexpr double kStep = 5e-5;  // [m]
    const int steps = static_cast<int>(std::ceil(std::abs(to - from) / kStep));
    for (int i = 0; i <= steps; ++i) {
      exchange(hand, from + (to - from) * i / std::max(steps, 1));
      await_tick(hand);
    }
  }
  /// Returns the force that the program must apply.
  static fw_tick exchange(fw_hand* hand, double z) {
    const fw_pose pose = at(z);
    fw_tick tick{};
    EXPECT_GE(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_OK) << fw_last_error();
    return tick;
  }
  static void await_tick(fw_hand* hand) {
    fw_tick tick{};
    fw_hand_latest(hand, &tick, sizeof tick);
    const std::uint64_t before = tick.number;
    test::eventually("a tick", [&] {
      return fw_hand_latest(hand, &tick, sizeof tick) == FW_OK && tick.number > before;
    });
  }
};

TEST_F(CApi, AHandOfTheCallerFeelsTheFloorAndAStaleOneFeelsNothing) {
  const fw_hand_options given = caller_options();
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  fw_tick tick{};
  test::eventually("a tick", [&] { return fw_hand_latest(hand, &tick, sizeof tick) == FW_OK; });
  EXPECT_STREQ(fw_zero_force_text(tick.zero_force_reason), "the device must be homed first");
  move(hand, 0.005, -0.002);
  test::eventually("the floor pushes", [&] {
    tick = exchange(hand, -0.002);
    return tick.force[2] > 0.5;
  });
  EXPECT_LT(tick.force[2], 1.1);
  EXPECT_EQ(tick.position[2], -0.002);
  EXPECT_EQ(tick.connected, 1u);
  EXPECT_FALSE(std::isnan(tick.balance));
  test::eventually("the force of a hand that does not move is gone", [&] {
    fw_hand_latest(hand, &tick, sizeof tick);
    return tick.force[2] == 0.0;
  });
  EXPECT_THAT(fw_zero_force_text(tick.zero_force_reason), HasSubstr("has given no new position"));
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

/// The program has the loop: each call is a tick with its pose, and tells its force.
TEST_F(CApi, AHandThatIsSteppedFeelsTheFloorAtThePoseOfEachCall) {
  fw_hand_options given = caller_options();
  given.device = "stepped:await_still=0";
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  fw_tick tick{};
  std::uint64_t before = 0;
  const auto step = [&](double z) {
    const fw_pose pose = at(z);
    const std::int32_t result = fw_hand_step(hand, &pose, &tick, sizeof tick);
    EXPECT_GE(result, FW_OK) << fw_last_error();
    if (result != FW_OK) return result;
    EXPECT_EQ(tick.position[2], z);
    EXPECT_GT(tick.number, before);
    before = tick.number;
    return result;
  };
  constexpr double kDeep = -0.002, kStep = 5e-5;  // [m]
  double z = 0.005;
  test::eventually("the floor pushes", [&] {
    if (step(z) == FW_OK) z = std::max(z - kStep, kDeep);
    return tick.force[2] > 0.5;
  });
  EXPECT_LT(tick.force[2], 1.1);
  EXPECT_FALSE(std::isnan(tick.balance));
  // The program pauses: nobody applies a force that the account knows of.
  test::eventually("the force of a program that pauses is taken off", [&] {
    fw_hand_latest(hand, &tick, sizeof tick);
    return tick.force[2] == 0.0;
  });
  const fw_pose pose = at(z);
  EXPECT_EQ(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("call fw_hand_step()"));
  EXPECT_EQ(fw_hand_stop(hand), FW_OK);
  test::eventually("the end", [&] { return step(z) == FW_ENDED; });
  EXPECT_EQ(tick.force[2], 0.0);
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  given.device = "caller";
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_hand_step(hand, &pose, &tick, sizeof tick), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("open it as \"stepped\""));
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

TEST_F(CApi, TicksComeInOrderAndTheRunEndsAfterItsDuration) {
  fw_hand_options given = options();
  given.duration = 0.3;
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  const fw_pose pose = at(0.0);
  fw_tick none{};
  EXPECT_EQ(fw_hand_exchange(hand, &pose, &none, sizeof none), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("it moves itself"));
  std::uint64_t next = 1;
  const auto take = [&] {
    std::array<fw_tick, 64> ticks{};
    std::uint32_t count = 0;
    while (fw_hand_ticks(hand, ticks.data(), sizeof(fw_tick), ticks.size(), &count) == FW_OK)
      for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(ticks[i].number, next++);
    EXPECT_EQ(count, 0u);
  };
  test::eventually("the end", [&] {
    take();
    return fw_hand_wait(hand, 0.01) == FW_ENDED;
  });
  take();
  EXPECT_GT(next, 2u);
  fw_session session{};
  EXPECT_EQ(fw_hand_session(hand, &session, sizeof session), FW_OK);
  EXPECT_EQ(session.servo_period, 1e-3);
  EXPECT_EQ(session.stiffness, 500.0);
  EXPECT_EQ(session.start_normal[2], 1.0);
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

TEST_F(CApi, APoseThatNoHandHasIsRefused) {
  fw_hand_options given = options();
  given.device = "caller";
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  fw_tick tick{};
  for (const double wrong : {nan, 1e300, -2e3}) {
    const fw_pose pose = at(wrong);
    EXPECT_EQ(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_ERROR_ARGUMENT) << wrong;
  }
  for (const double wrong : {nan, 0.0, 1e200}) {
    fw_pose pose = at(0.0);
    pose.orientation[0] = wrong;
    EXPECT_EQ(fw_hand_exchange(hand, &pose, &tick, sizeof tick), FW_ERROR_ARGUMENT) << wrong;
  }
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

/// After the run has ended no force is told, whatever the last tick held.
TEST_F(CApi, AfterTheEndThereIsNoForce) {
  const fw_hand_options given = caller_options();
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  await_tick(hand);
  move(hand, 0.005, -0.002);
  test::eventually("the floor pushes", [&] { return exchange(hand, -0.002).force[2] > 0.5; });
  EXPECT_EQ(fw_hand_stop(hand), FW_OK);
  const fw_pose pose = at(-0.002);
  fw_tick tick{};
  test::eventually("the end",
                   [&] { return fw_hand_exchange(hand, &pose, &tick, sizeof tick) == FW_ENDED; });
  for (const double force : tick.force) EXPECT_EQ(force, 0.0);
  EXPECT_EQ(fw_hand_latest(hand, &tick, sizeof tick), FW_OK);
  for (const double force : tick.force) EXPECT_EQ(force, 0.0);
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
}

/// A real-time thread may call these.
TEST_F(CApi, AHandIsMovedAndReadWithoutTheHeap) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate";
#endif
  const fw_hand_options given = caller_options();
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  await_tick(hand);
  const fw_pose pose = at(0.005);
  fw_tick tick{};
  std::array<fw_tick, 64> ticks{};
  std::uint32_t count = 0;
  EXPECT_EQ(test::uses_of_heap([&] { return fw_hand_exchange(hand, &pose, &tick, sizeof tick); }),
            0u);
  EXPECT_EQ(test::uses_of_heap([&] { return fw_hand_latest(hand, &tick, sizeof tick); }), 0u);
  EXPECT_EQ(test::uses_of_heap([&] {
              return fw_hand_ticks(hand, ticks.data(), sizeof tick, ticks.size(), &count);
            }),
            0u);
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  const std::size_t before = test::allocations();
  fw_hand_open(nullptr, &hand);
  EXPECT_GT(test::allocations(), before) << "the counter does not see the library";
}

/// --link of `more` stands before the socket of the library, too: nothing comes through this one.
TEST_F(CApi, AnEmulatedLinkIsBetweenTheHandAndTheServer) {
  fw_hand_options given = options();
  std::array<const char*, 8> more = {
      "--flight-recorder", "off", "--let-go-after", "1", "--link", "loss=100", "--hold-time", "1"};
  given.more = more.data();
  given.more_count = static_cast<std::uint32_t>(more.size());
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  fw_tick tick{};
  test::eventually("200 ticks", [&] {
    return fw_hand_latest(hand, &tick, sizeof tick) == FW_OK && tick.number > 200;
  });
  EXPECT_EQ(tick.reply_age, -1.0);
  fw_hand_close(hand);
}

// A hand that touches nothing: ticks that are late on a busy machine make no debt.
constexpr std::array<const char*, 6> kFarAway = {"--flight-recorder", "off", "--let-go-after", "1",
                                                 "--reconnect",       "0"};
constexpr const char* kFarDevice = "simulated:center=0,0,0.5";

TEST_F(CApi, TwoHandsShareTheScene) {
  fw_hand_options given = options();
  given.device = kFarDevice;
  given.more = kFarAway.data();
  given.more_count = static_cast<std::uint32_t>(kFarAway.size());
  fw_hand *first = nullptr, *second = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &first), FW_OK) << fw_last_error();
  ASSERT_EQ(fw_hand_open(&given, &second), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_hand_close(first), FW_OK) << fw_last_error();
  await_tick(second);
  EXPECT_EQ(fw_hand_stop(second), FW_OK);
  EXPECT_EQ(fw_hand_wait(second, 10.0), FW_ENDED);
  EXPECT_EQ(fw_hand_close(second), FW_OK) << fw_last_error();
}

TEST_F(CApi, AServerThatEndsIsTold) {
  fw_hand_options given = options();
  given.device = kFarDevice;
  given.more = kFarAway.data();
  given.more_count = static_cast<std::uint32_t>(kFarAway.size());
  fw_hand* hand = nullptr;
  ASSERT_EQ(fw_hand_open(&given, &hand), FW_OK) << fw_last_error();
  test::eventually("an answer, so that the server has the hand's address", [&] {
    fw_tick tick{};
    return fw_hand_latest(hand, &tick, sizeof tick) == FW_OK && tick.reply_age >= 0.0;
  });
  server.reset();
  EXPECT_EQ(fw_hand_wait(hand, 20.0), FW_ENDED);
  EXPECT_EQ(fw_hand_close(hand), FW_ENDED);
  EXPECT_THAT(fw_last_error(), HasSubstr("shutting down"));
}

TEST_F(CApi, WrongArgumentsAreNamed) {
  fw_hand* hand = nullptr;
  EXPECT_EQ(fw_hand_open(nullptr, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("hand_options is null"));
  fw_hand_options given = options();
  EXPECT_EQ(fw_hand_open(&given, nullptr), FW_ERROR_ARGUMENT);
  given.server = nullptr;
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("server is null"));
  given = options();
  given.device = "no_such_device";
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("no_such_device"));
  for (const char* fw_hand_options::*text : {&fw_hand_options::name, &fw_hand_options::scene}) {
    given = options();
    given.*text = "\xff";
    EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
    EXPECT_THAT(fw_last_error(), HasSubstr("the name is not text in UTF-8"));
  }
  given = options();
  const char* wrong[] = {"--stifness", "3"};
  given.more = wrong;
  given.more_count = 2;
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("--stifness"));
  for (const char* of_the_program : {"--help", "--version", "--check", "--report=a.json"}) {
    given = options();
    given.more = &of_the_program;
    given.more_count = 1;
    EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
    EXPECT_THAT(fw_last_error(), HasSubstr("for feltwire-client only"));
  }
  given = options();
  given.device = "caller";
  given.stale_after = 5.0;
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("stale_after"));
  for (const auto& [misspelled, says] :
       {std::pair("caller:map_scal=2", "device caller: map_scal is no setting; did you mean map"),
        std::pair("caller:,map_scale=2", "device caller: there is nothing between two commas"),
        std::pair("caller:map_scale=2:a", "write it as caller:map_scale=2")}) {
    given = options();
    given.device = misspelled;
    EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_ARGUMENT) << misspelled;
    EXPECT_THAT(fw_last_error(), HasSubstr(says));
  }
  given = options();
  given.scene = "no_such_scene";
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_REFUSED);
  EXPECT_THAT(fw_last_error(), HasSubstr("no_such_scene"));
  EXPECT_EQ(hand, nullptr);
  server.reset();
  given = options();
  EXPECT_EQ(fw_hand_open(&given, &hand), FW_ERROR_SERVER);
  EXPECT_EQ(fw_hand_close(nullptr), FW_OK);
  fw_tick tick{};
  EXPECT_EQ(fw_hand_latest(nullptr, &tick, sizeof tick), FW_ERROR_ARGUMENT);
}

/// A program that was compiled with another version of the header has structs of other sizes.
TEST_F(CApi, StructsOfOtherVersionsWork) {
  struct Older {
    fw_hand_options options;
  } older{options()};
  older.options.struct_size = offsetof(fw_hand_options, stale_after);
  older.options.stale_after = -1.0;  // behind the older struct: anything
  older.options.device = "caller";
  fw_hand* hand = nullptr;
  // The older program has no `more` either.
  EXPECT_EQ(fw_hand_open(&older.options, &hand), FW_OK) << fw_last_error();
  std::array<unsigned char, sizeof(fw_tick) + 16> newer{};
  newer.fill(0xff);
  test::eventually("a tick", [&] {
    return fw_hand_latest(hand, reinterpret_cast<fw_tick*>(newer.data()), newer.size()) == FW_OK;
  });
  fw_tick tick;
  std::memcpy(&tick, newer.data(), sizeof tick);
  EXPECT_EQ(tick.struct_size, newer.size());
  for (std::size_t i = sizeof tick; i < newer.size(); ++i) EXPECT_EQ(newer[i], 0) << i;
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();

  struct Newer {
    fw_hand_options options;
    std::uint64_t field;
  } later{options(), 0};
  later.options.struct_size = sizeof later;
  EXPECT_EQ(fw_hand_open(&later.options, &hand), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  later.field = 1;
  EXPECT_EQ(fw_hand_open(&later.options, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("does not know"));
  later.options.struct_size = 0;
  EXPECT_EQ(fw_hand_open(&later.options, &hand), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("fw_hand_options_default() first"));
}

TEST(CApiTexts, EachThreadHasItsError) {
  fw_hand* hand = nullptr;
  EXPECT_EQ(fw_hand_open(nullptr, &hand), FW_ERROR_ARGUMENT);
  std::thread([] { EXPECT_STREQ(fw_last_error(), ""); }).join();
  EXPECT_STRNE(fw_last_error(), "");
  for (int result = FW_ERROR_INTERNAL; result <= FW_ENDED; ++result)
    EXPECT_STRNE(fw_result_text(result), "no result of this library") << result;
  EXPECT_STREQ(fw_result_text(77), "no result of this library");
  EXPECT_STREQ(fw_zero_force_text(1000), "");
}

TEST(CApiTexts, TheVersionIsThatOfTheProject) {
  const std::uint32_t version = fw_version();
  EXPECT_EQ(std::to_string(version >> 16) + "." + std::to_string(version >> 8 & 0xff) + "." +
                std::to_string(version & 0xff),
            FELTWIRE_VERSION);
}

/// The account reckons with the force that the program says it applies, weighted by time.
TEST(CallerDevice, TellsTheMeanForceBetweenTwoReadings) {
  CallerDevice device(builtin_device("simulated"), 0.02);
  const auto at = [](double z) { return CallerDevice::Move{.pose = {Vec3(0, 0, z)}}; };
  const auto up = [](double force) { return Command{.elastic = Vec3(0, 0, force)}; };
  const Nanoseconds start = std::chrono::seconds(1);
  const Nanoseconds ms = std::chrono::milliseconds(1);
  EXPECT_EQ(device.read(start).withheld, Withheld::not_homed);
  device.exchange(at(0.0), start, up(2.0));
  DeviceReading reading = device.read(start);
  EXPECT_TRUE(reading.fresh);
  EXPECT_EQ(reading.held->force().z(), 0.0) << "nothing was applied before";
  // 2 N for 1 ms, then 5 N for 3 ms.
  device.exchange(at(1e-4), start + ms, up(5.0));
  device.exchange(at(2e-4), start + 4 * ms, up(1.0));
  reading = device.read(start + 4 * ms);
  EXPECT_EQ(reading.pose.position.z(), 2e-4);
  EXPECT_NEAR(reading.held->force().z(), (2.0 * 1.0 + 5.0 * 3.0) / 4.0, 1e-12);
  EXPECT_FALSE(device.read(start + 5 * ms).fresh);
  EXPECT_EQ(device.read(start + 25 * ms).withheld, Withheld::not_moved);
  // The servo stands still for 200 moves of 1 ms, at 1 N and 3 N in turn. What the ring had no room
  // for comes with the next move.
  for (int i = 0; i < 200; ++i)
    device.exchange(at(0.0), start + (5 + i) * ms, up(i % 2 == 0 ? 1.0 : 3.0));
  const double first = device.read(start + 204 * ms).held->force().z();
  EXPECT_NEAR(first, 2.0, 0.1);
  device.exchange(at(3e-4), start + 205 * ms, up(0.0));
  reading = device.read(start + 205 * ms);
  EXPECT_NEAR(reading.held->force().z(), 2.0, 0.1);
  EXPECT_EQ(reading.pose.position.z(), 3e-4);
  device.release();
  EXPECT_EQ(device.write(up(4.0)).force().z(), 0.0);
}

/// A step is a tick with its pose. The account hears of the force that the program applied since
/// the last step, however late the next one is.
TEST(CallerDevice, AStepIsATickAndTellsTheForceSinceTheLast) {
  constexpr double kPeriod = 1e-3;  // [s]
  CallerDevice device(builtin_device("simulated"), 0.02, kPeriod);
  EXPECT_EQ(device.longest_tick(), from_seconds(kPeriod));
  EXPECT_TRUE(device.await_tick(monotonic_now()));
  EXPECT_EQ(device.read(monotonic_now()).withheld, Withheld::not_homed) << "no step has begun";
  const auto up = [](double force) { return Command{.elastic = Vec3(0, 0, force)}; };
  std::vector<double> heights, held;  // by the servo's thread
  std::atomic<int> ticks{0};
  std::jthread servo([&](const std::stop_token& end) {
    while (!end.stop_requested()) {
      device.await_tick(monotonic_now() + from_seconds(kPeriod));
      const DeviceReading reading = device.read(monotonic_now());
      if (!reading.fresh || reading.withheld != Withheld::nothing) continue;
      heights.push_back(reading.pose.position.z());
      held.push_back(reading.held ? reading.held->force().z() : 0.0);
      ++ticks;
      device.ticked();
    }
  });
  const Nanoseconds far = monotonic_now() + std::chrono::minutes(1);
  Nanoseconds at = std::chrono::seconds(1);
  for (int i = 1; i <= 100; ++i) {
    at += i % 10 == 0 ? std::chrono::milliseconds(30) : std::chrono::milliseconds(1);
    ASSERT_TRUE(device.step({.pose = {Vec3(0, 0, 1e-3 * i)}}, at, far));
    EXPECT_EQ(ticks.load(), i) << "the tick is there when the step returns";
    device.applies(up(i));
  }
  servo.request_stop();
  servo.join();
  ASSERT_EQ(heights.size(), 100u);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(heights[i], 1e-3 * (i + 1));
    EXPECT_EQ(held[i], i) << "the force of the step before";
  }
  EXPECT_FALSE(device.step({}, at, monotonic_now())) << "no servo is there";
}

TEST(LatestValue, AReaderNeverSeesHalfAValue) {
  struct Pair {
    std::array<std::uint64_t, 9> same{};
  };
  LatestValue<Pair> latest;
  Pair pair;
  EXPECT_EQ(latest.get(pair), 0u);
  constexpr std::uint64_t kValues = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      Pair next;
      next.same.fill(i);
      latest.put(next);
    }
  });
  std::uint64_t newest = 0;
  while (newest < kValues) {
    const std::uint64_t number = latest.get(pair);
    if (number == 0) continue;
    EXPECT_GE(pair.same[0], newest);
    EXPECT_EQ(pair.same[0], number);
    newest = pair.same[0];
    for (const std::uint64_t word : pair.same) ASSERT_EQ(word, newest);
  }
  writer.join();
}

}  // namespace
}  // namespace feltwire::c_api_test
