// An observer of the C interface, against a server of this process.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "client/c_api/feltwire.h"
#include "core/base/latest_list.hpp"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/client/c_api/heap_uses.hpp"
#include "tests/core/moving.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_test {
namespace {

using ::testing::HasSubstr;

constexpr unsigned kTouches = 1u << 3;  // of fw_seen_hand::states

fw_observer* observe(const fw_observer_options& options) {
  fw_observer* observer = nullptr;
  EXPECT_EQ(fw_observer_open(&options, &observer), FW_OK) << fw_last_error();
  return observer;
}

std::vector<fw_seen_hand> hands_of(const fw_observer* observer) {
  std::vector<fw_seen_hand> hands(64);
  std::uint32_t count = 0;
  EXPECT_GE(fw_observer_hands(observer, hands.data(), sizeof(fw_seen_hand), 64, &count), FW_OK);
  hands.resize(count);
  return hands;
}

fw_scene_state state_of(const fw_observer* observer) {
  fw_scene_state state{};
  EXPECT_GE(fw_observer_latest(observer, &state, sizeof state), FW_OK);
  return state;
}

std::string name_of(fw_observer* observer, std::uint32_t number) {
  std::array<char, 64> text{};
  fw_observer_hand_name(observer, number, text.data(), text.size());
  return text.data();
}

TEST(ObserverApi, SeesAHandThatPressesTheFloorAndItsEnd) {
  const ApiServer server;
  fw_observer* observer = observe(server.observer_options());
  ASSERT_NE(observer, nullptr);
  test::eventually("a view", [&] { return state_of(observer).number > 0; });
  EXPECT_EQ(state_of(observer).hands, 0u);
  EXPECT_EQ(state_of(observer).connected, 1u);
  fw_hand* hand = nullptr;
  constexpr std::array<const char*, 6> kPatient = {
      "--flight-recorder", "off", "--let-go-after", "1", "--hold-time", "1"};
  fw_hand_options options = server.hand_options();
  options.more = kPatient.data();
  options.more_count = kPatient.size();
  ASSERT_EQ(fw_hand_open(&options, &hand), FW_OK) << fw_last_error();
  fw_seen_hand seen{};
  // The account of a hand on a slow machine may leave little of the force.
  test::eventually("the floor pushes", [&] {
    const auto hands = hands_of(observer);
    if (!hands.empty()) seen = hands.front();
    return (seen.states & kTouches) != 0 && seen.commanded[2] > 0.1 && seen.force[2] > 0.0;
  });
  EXPECT_EQ(seen.struct_size, sizeof seen);
  EXPECT_EQ(seen.number, 2u) << "the observer is the first session";
  EXPECT_LT(seen.position[2], 0.01);
  EXPECT_GT(seen.samples, 0u);
  EXPECT_GT(seen.time, 0.0);
  EXPECT_FALSE(std::isnan(seen.balance));
  EXPECT_NEAR(seen.orientation[0], 1.0, 1e-6);
  test::eventually("its name", [&] { return name_of(observer, 2) == "libfeltwire"; });
  EXPECT_EQ(name_of(observer, 77), "");
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  test::eventually("the hand is gone", [&] { return state_of(observer).hands == 0; });
  EXPECT_TRUE(hands_of(observer).empty());
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(ObserverApi, SeesSixteenHands) {
  constexpr std::uint32_t kHands = 16;
  const ApiServer server;
  constexpr std::array<const char*, 8> kSlow = {
      "--flight-recorder", "off", "--let-go-after", "1", "--rate", "60", "--hold-time", "1"};
  fw_hand_options options = server.hand_options();
  options.more = kSlow.data();
  options.more_count = kSlow.size();
  std::array<fw_hand*, kHands> hands{};
  for (fw_hand*& hand : hands) ASSERT_EQ(fw_hand_open(&options, &hand), FW_OK) << fw_last_error();
  fw_observer* observer = observe(server.observer_options());
  ASSERT_NE(observer, nullptr);
  test::eventually("all hands with samples", [&] {
    const auto seen = hands_of(observer);
    return seen.size() == kHands &&
           std::ranges::all_of(seen, [](const fw_seen_hand& hand) { return hand.samples > 0; });
  });
  EXPECT_EQ(state_of(observer).hands, kHands);
  const auto seen = hands_of(observer);
  EXPECT_TRUE(std::ranges::is_sorted(seen, {}, &fw_seen_hand::number));
  std::array<fw_seen_hand, 5> first{};
  std::uint32_t count = 0;
  EXPECT_EQ(fw_observer_hands(observer, first.data(), sizeof(fw_seen_hand), 5, &count), FW_OK);
  EXPECT_EQ(count, 5u);
  EXPECT_EQ(first[4].number, seen[4].number);
#ifndef FELTWIRE_SANITIZED  // which allocate
  std::vector<fw_seen_hand> all(kHands);
  std::vector<fw_seen_body> bodies(4);
  fw_scene_state state{};
  EXPECT_EQ(test::uses_of_heap([&] { return fw_observer_latest(observer, &state, sizeof state); }),
            0u);
  EXPECT_EQ(test::uses_of_heap([&] {
              return fw_observer_hands(observer, all.data(), sizeof all[0], kHands, &count);
            }),
            0u);
  EXPECT_EQ(test::uses_of_heap([&] {
              return fw_observer_bodies(observer, bodies.data(), sizeof bodies[0], 4, &count);
            }),
            0u);
#endif
  for (fw_hand* hand : hands) EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  test::eventually("all hands are gone", [&] { return hands_of(observer).empty(); });
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(ObserverApi, SeesWhatMovesAndWaitsForEachState) {
  const ApiServer server(
      test::moving({test::object("floor", Plane{}, {.stiffness = 500}),
                    test::object("ball", Sphere{0.03}, {.stiffness = 1000}, {0, 0, 2})},
                   {-1, 0}, {test::body("ball", 0.2, {0, 0, 2})}));
  fw_observer_options options = server.observer_options();
  options.scene = "moving";
  fw_observer* observer = observe(options);
  std::uint64_t number = 0;
  fw_seen_body ball{};
  double height = 3.0;
  test::eventually("a fall of 0.1 m", [&] {
    EXPECT_EQ(fw_observer_wait(observer, number, 20.0), FW_OK) << fw_last_error();
    const fw_scene_state state = state_of(observer);
    EXPECT_GT(state.number, number);
    number = state.number;
    std::uint32_t count = 0;
    fw_observer_bodies(observer, &ball, sizeof ball, 1, &count);
    if (count == 0) return false;
    EXPECT_EQ(ball.object, 1u);
    EXPECT_LE(ball.position[2], height + 1e-6);
    height = ball.position[2];
    return height < 1.9;
  });
  EXPECT_EQ(fw_observer_wait(observer, std::numeric_limits<std::uint64_t>::max(), 0.0), FW_NOTHING);
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(ObserverApi, AServerThatEndsIsTold) {
  ApiServer server;
  fw_observer_options options = server.observer_options();
  options.patience = 0.0;
  fw_observer* observer = observe(options);
  test::eventually("a view", [&] { return state_of(observer).number > 0; });
  server.server.reset();
  EXPECT_EQ(fw_observer_wait(observer, std::numeric_limits<std::uint64_t>::max(), 20.0), FW_ENDED);
  EXPECT_THAT(fw_last_error(), HasSubstr("shutting down"));
  EXPECT_EQ(state_of(observer).connected, 0u);
  EXPECT_EQ(fw_observer_close(observer), FW_ENDED);
  EXPECT_THAT(fw_last_error(), HasSubstr("shutting down"));
}

TEST(ObserverApi, ALostSessionIsFoundAgain) {
  const ApiServer server;
  fw_observer* observer = observe(server.observer_options());
  test::eventually("a view", [&] { return state_of(observer).number > 0; });
  fw_admin* admin = nullptr;
  const fw_admin_options options = server.admin_options();
  ASSERT_EQ(fw_admin_open(&options, &admin), FW_OK) << fw_last_error();
  const std::array<const char*, 2> words = {"evict", "1"};
  const char* answer = nullptr;
  EXPECT_EQ(fw_admin_request(admin, words.data(), 2, &answer), FW_OK) << fw_last_error();
  std::array<char, 256> text{};
  test::eventually("it is told", [&] {
    return fw_observer_message(observer, text.data(), text.size()) == FW_OK;
  });
  EXPECT_THAT(text.data(), HasSubstr("an admin of the server ended"));
  test::eventually("it observes again", [&] {
    return fw_observer_message(observer, text.data(), text.size()) == FW_OK;
  });
  EXPECT_STREQ(text.data(), "the scene is observed again");
  const double before = state_of(observer).time;
  test::eventually("newer views", [&] {
    const fw_scene_state state = state_of(observer);
    return state.connected == 1 && state.time > before;
  });
  EXPECT_EQ(fw_admin_close(admin), FW_OK);
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(ObserverApi, ATokenOpensWhatItIsFor) {
  const IssuedToken eye = issue_token("eye", "floor", Role::observer, std::nullopt),
                    other = issue_token("other", "room", Role::observer, std::nullopt);
  const ApiServer server(testing::floor_scene(), {eye.token, other.token});
  const std::string eye_file = server.write_token("eye", eye),
                    other_file = server.write_token("other", other);
  fw_observer_options options = server.observer_options();
  options.token_file = other_file.c_str();
  fw_observer* observer = nullptr;
  EXPECT_EQ(fw_observer_open(&options, &observer), FW_ERROR_REFUSED);
  EXPECT_THAT(fw_last_error(), HasSubstr("token"));
  EXPECT_EQ(observer, nullptr);
  options.token_file = eye_file.c_str();
  observer = observe(options);
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(ObserverApi, WrongArgumentsAreNamed) {
  const ApiServer server;
  fw_observer* observer = nullptr;
  const auto expect_error = [&](const fw_observer_options& given, const char* text) {
    EXPECT_EQ(fw_observer_open(&given, &observer), FW_ERROR_ARGUMENT) << text;
    EXPECT_THAT(fw_last_error(), HasSubstr(text));
  };
  EXPECT_EQ(fw_observer_open(nullptr, &observer), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("observer_options is null"));
  fw_observer_options given = server.observer_options();
  EXPECT_EQ(fw_observer_open(&given, nullptr), FW_ERROR_ARGUMENT);
  given.server = nullptr;
  expect_error(given, "observer_options.server is null");
  given = server.observer_options();
  given.scene = nullptr;
  expect_error(given, "observer_options.scene is null");
  given.scene = "r\xe4ume";
  expect_error(given, "observer_options.scene is not text in UTF-8");
  given = server.observer_options();
  given.name = "\xff";
  expect_error(given, "observer_options.name is not text in UTF-8");
  for (const double wrong : {0.0, 0.2, std::numeric_limits<double>::quiet_NaN()}) {
    given = server.observer_options();
    given.period = wrong;
    expect_error(given, "period must be from 0.001 to 0.1 s");
  }
  given = server.observer_options();
  given.patience = -1.0;
  expect_error(given, "patience");
  given = server.observer_options();
  given.token_file = "no_such_file";
  expect_error(given, "no_such_file");
  given = server.observer_options();
  given.scene = "no_such_scene";
  EXPECT_EQ(fw_observer_open(&given, &observer), FW_ERROR_REFUSED);
  EXPECT_THAT(fw_last_error(), HasSubstr("no_such_scene"));
  EXPECT_EQ(fw_observer_close(nullptr), FW_OK);
  fw_scene_state state{};
  EXPECT_EQ(fw_observer_latest(nullptr, &state, sizeof state), FW_ERROR_ARGUMENT);
  observer = observe(server.observer_options());
  std::uint32_t count = 0;
  std::array<char, 8> text{};
  fw_seen_hand hand{};
  EXPECT_EQ(fw_observer_latest(observer, nullptr, sizeof state), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_latest(observer, &state, 3), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_hands(observer, nullptr, sizeof hand, 1, &count), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_hands(observer, &hand, sizeof hand, 1, nullptr), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_hands(observer, &hand, 9, 1, &count), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_message(observer, text.data(), 0), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_hand_name(observer, 1, nullptr, 8), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_wait(observer, 0, -1.0), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

/// A program that was compiled with another version of the header has structs of other sizes.
TEST(ObserverApi, StructsOfOtherVersionsWork) {
  const ApiServer server;
  fw_observer_options older = server.observer_options();
  older.struct_size = offsetof(fw_observer_options, period);
  older.period = older.patience = -1.0;  // behind the older struct: anything
  fw_observer* observer = observe(older);
  fw_hand* hand = nullptr;
  const fw_hand_options options = server.hand_options();
  ASSERT_EQ(fw_hand_open(&options, &hand), FW_OK) << fw_last_error();
  test::eventually("the hand", [&] { return hands_of(observer).size() == 1; });
  constexpr std::size_t kOld = offsetof(fw_seen_hand, force), kNew = sizeof(fw_seen_hand) + 16;
  for (const std::size_t size : {kOld, kNew}) {
    std::array<unsigned char, kNew> bytes{};
    bytes.fill(0xff);
    std::uint32_t count = 0;
    EXPECT_EQ(fw_observer_hands(observer, reinterpret_cast<fw_seen_hand*>(bytes.data()),
                                static_cast<std::uint32_t>(size), 1, &count),
              FW_OK);
    ASSERT_EQ(count, 1u);
    fw_seen_hand seen{};
    std::memcpy(&seen, bytes.data(), std::min(size, sizeof seen));
    EXPECT_EQ(seen.struct_size, size);
    EXPECT_EQ(seen.number, 2u);
    for (std::size_t i = std::min(size, sizeof seen); i < kNew; ++i)
      EXPECT_EQ(bytes[i], size == kOld ? 0xff : 0) << i;
  }
  EXPECT_EQ(fw_hand_close(hand), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
  struct Newer {
    fw_observer_options options;
    std::uint64_t field;
  } newer{server.observer_options(), 0};
  newer.options.struct_size = sizeof newer;
  EXPECT_EQ(fw_observer_close(observe(newer.options)), FW_OK) << fw_last_error();
  newer.field = 1;
  EXPECT_EQ(fw_observer_open(&newer.options, &observer), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("does not know"));
}

TEST(ObserverApi, AChildProcessHasNoObserverOfItsParent) {
  const ApiServer server;
  fw_observer* observer = observe(server.observer_options());
  test::eventually("a view", [&] { return state_of(observer).number > 0; });
  const pid_t child = ::fork();
  if (child == 0) {
    fw_scene_state state{};
    ::_exit(fw_observer_latest(observer, &state, sizeof state) == FW_ERROR_ARGUMENT ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(fw_observer_close(observer), FW_OK) << fw_last_error();
}

TEST(LatestList, AReaderNeverSeesHalfAList) {
  using Item = std::array<std::uint64_t, 3>;
  constexpr std::size_t kMost = 7;
  LatestList<Item> latest(kMost);
  std::array<Item, kMost> read{};
  std::size_t count = 99;
  EXPECT_EQ(latest.get(read.data(), sizeof(Item), kMost, count), 0u);
  EXPECT_EQ(count, 0u);
  constexpr std::uint64_t kLists = 100'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLists; ++i) {
      const std::vector<Item> items(i % (kMost + 2), Item{i, i, i});
      latest.put(items);
    }
  });
  for (std::uint64_t newest = 0; newest < kLists;) {
    const std::uint64_t number = latest.get(read.data(), sizeof(Item), kMost, count);
    if (number == 0) continue;
    ASSERT_GE(number, newest);
    newest = number;
    ASSERT_EQ(count, std::min<std::size_t>(number % (kMost + 2), kMost)) << "more have no room";
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(read[i], (Item{number, number, number}));
  }
  writer.join();
}

}  // namespace
}  // namespace feltwire::c_api_test
