// The program stalls for up to two seconds during a force, and the handle moves with the clock
// meanwhile. The test measures the excess of the hand's energy over the device's dissipation, from
// the true motion.

#include <gmock/gmock.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/servo/servo_thread.hpp"
#include "core/local_model/contact_budget.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/real_time.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/touched_surfaces.hpp"
#include "tests/core/heavy_geometry.hpp"
#include "tests/devices/shared_page.hpp"
#include "tests/devices/simulated_mass.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::stall_test {
namespace {

using stand_in::NewPage;
using test::Outcome;
using test::Program;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

constexpr double kFelt = 0.2;                        // [N]
constexpr double kRounding = 1e-12;                  // [J]
constexpr int kStalls[] = {20, 60, 200, 600, 2000};  // [ms]

/// A session's bounding method and side. Each has an energy account.
struct Law {
  const char* name;
  Words options;
  std::string_view mode;
  BoundingSide side = BoundingSide::client;
};
const Law kLaws[] = {{"shaped", {}, kSessionMethod},
                     {"contact_frame", {"--mode", "contact_frame"}, "contact_frame"},
                     {"at_the_server",
                      {"--mode", "contact_frame,side=server"},
                      "contact_frame",
                      BoundingSide::server}};

/// A floor with this stiffness [N/m] where the substitute device taps.
struct Floor {
  explicit Floor(double stiffness) {
    std::ofstream(folder / "floor.json")
        << R"({"name": "floor", "materials": [{"name": "m", "stiffness": )" << stiffness
        << R"(, "static_friction": 0.4, "dynamic_friction": 0.3}],)"
        << R"("objects": [{"name": "floor", "plane": {}, "material": "m"}]})";
    server.emplace(FELTWIRE_SERVER_PROGRAM, Words{"--scene", folder / "floor.json", "--port", "0",
                                                  "--state", folder / "state"});
    server->line();  // This line has the fingerprint.
    const std::string listening = server->line();
    if (std::sscanf(listening.c_str(), "listening: control tcp %u", &port) != 1)
      throw std::runtime_error("no server: " + server->finish().error);
    page->waits.store(0.3);
    page->by_clock.store(true);
  }
  std::unique_ptr<Program> client(const Words& options) const {
    Words all{"--connect",
              "127.0.0.1:" + std::to_string(port),
              "--token-file",
              folder / "state/local.token",
              "--fingerprint-file",
              folder / "state/fingerprint",
              "--scene",
              "floor",
              "--device",
              "plugin:" FELTWIRE_PLUGIN_STAND_IN ",await_still=0.1",
              "--report",
              folder / "report.json"};
    all.insert(all.end(), options.begin(), options.end());
    return std::make_unique<Program>(FELTWIRE_CLIENT_PROGRAM, all);
  }
  nlohmann::json report() const {
    std::ifstream text(folder / "report.json");
    return nlohmann::json::parse(text);
  }
  /// Waits for a force, and returns false if none comes. On a busy machine, late ticks may cause a
  /// debt, which ends the force.
  bool feels(double force) const {
    constexpr std::chrono::seconds kLongest{15};
    return test::becomes([&] { return page->force.load() > force; }, kLongest);
  }

  test::TemporaryFolder folder;
  NewPage page{folder / "plugin.page"};
  std::optional<Program> server;
  unsigned port = 0;
};

struct Stall : ::testing::TestWithParam<Law> {};

/// The server does not answer for this time, and then continues.
TEST_P(Stall, OfAServerGivesTheHandNoEnergy) {
  for (const double stiffness : {900.0, 5e3}) {
    Floor floor(stiffness);
    const auto client = floor.client(GetParam().options);
    bool feels = floor.feels(kFelt);
    EXPECT_TRUE(feels);
    for (const int stall : kStalls) {
      floor.server->signal(SIGSTOP);
      const long stopped = floor.page->ticks;
      test::eventually("it ticks", [&] { return floor.page->ticks >= stopped + stall; });
      floor.server->signal(SIGCONT);
      feels = feels && floor.feels(kFelt);
    }
    client->signal(SIGINT);
    const Outcome outcome = client->finish();
    const nlohmann::json report = floor.report();
    EXPECT_EQ(outcome.status, feels ? 0 : 1) << outcome.error;
    EXPECT_EQ(report["debt_fault"].is_null(), feels) << outcome.error;
    EXPECT_TRUE(feels || report["missed_deadlines"] > 0) << outcome.error;
    EXPECT_EQ(floor.page->force, 0.0);
    EXPECT_LE(floor.page->made, kRounding) << stiffness;
    if (testing::measures())
      std::printf("%-14s %6.0f N/m: %.2f N, %.2e J made; %s\n", GetParam().name, stiffness,
                  floor.page->largest_force.load(), floor.page->made.load(), outcome.out.c_str());
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, Stall, ::testing::ValuesIn(kLaws),
                         [](const auto& law) { return std::string(law.param.name); });

/// A stall of the device must lead to its release. A server cannot cause such a stall. The hand
/// must get no energy after the release.
TEST(DeviceStall, IsLetGoWithinTheTimeOfTheWatch) {
  for (const int stall : {20, 200, 2000}) {
    Outcome outcome;
    nlohmann::json report;
    double made = 0.0, force = 0.0, largest = 0.0;
    // A busy machine may delay the complete thread for this time. In this case the test tries
    // again.
    constexpr int kTries = 5;
    for (int n = 0; n < kTries && (n == 0 || report["let_go"]["in"] != "read"); ++n) {
      Floor floor(900.0);
      const auto client = floor.client({"--let-go-after", "0.005"});
      EXPECT_TRUE(floor.feels(3.0 * kFelt) || client->ended());
      floor.page->stall.store(stall);
      outcome = client->finish();
      report = floor.report();
      made = floor.page->made, force = floor.page->force, largest = floor.page->largest_force;
    }
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.error, HasSubstr("the device was let go: read() of the device"));
    EXPECT_EQ(force, 0.0);
    const double still = report["let_go"]["still_s"];
    EXPECT_GE(still, 0.005);
    if (still < 0.006) {  // Otherwise the stall detector was delayed.
      EXPECT_LE(made, kRounding) << stall;
    }
    if (testing::measures())
      std::printf("%4d ms: let go after %.1f ms, %.2f N, %.2e J made\n", stall, 1e3 * still,
                  largest, made);
  }
}

/// The mass of the substitute in this program. The clock moves the mass.
class ClockedHand final : public Device {
 public:
  explicit ClockedHand(const stand_in::SimulatedMass& mass) : mass_(mass) {
    spec_.name = "clocked";
    spec_.damping = mass.damping;
    spec_.apparent_mass = spec_.least_mass = mass.mass;
    spec_.coulomb_friction = spec_.least_friction = mass.friction;
    spec_.position_resolution = mass.quantum;
    spec_.max_force = spec_.continuous_force = 8.0;
  }
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    move_on();
    const stand_in::Three at = mass_.sensed();
    DeviceReading reading;
    reading.pose.position = Vec3(at[0], at[1], at[2]);
    return reading;
  }
  Command write(const Command& on_hand) noexcept override {
    move_on();
    if (released_) return {};
    const Vec3 force = on_hand.force();
    force_ = {force.x(), force.y(), force.z()};
    told.store(force.norm());
    return on_hand;
  }
  void release() noexcept override {
    if (!released_) released_at_ = monotonic_now();
    released_ = true;
    told.store(0.0);
  }
  /// Returns the result after the servo thread has ended.
  double made() {
    move_on();
    return mass_.most_made;
  }
  double largest_force() const { return mass_.largest_force; }
  std::atomic<double> told{0.0};  // [N]

 private:
  void advance_to(Nanoseconds time) noexcept {
    if (time > moved_to_) mass_.advance(seconds(time - moved_to_), force_);
    moved_to_ = std::max(moved_to_, time);
  }
  void move_on() noexcept {
    const Nanoseconds now = monotonic_now();
    if (moved_to_.count() == 0) moved_to_ = now;
    if (released_) {
      advance_to(std::min(now, released_at_.load()));
      force_ = {};
    }
    advance_to(now);
  }

  stand_in::SimulatedMass mass_;
  DeviceSpec spec_ = builtin_device("simulated");
  stand_in::Three force_{};
  Nanoseconds moved_to_{0};
  std::atomic<Nanoseconds> released_at_{Nanoseconds(0)};
  std::atomic<bool> released_{false};
};

/// The worst case of a server. The replies push along the hand's movement with the device's largest
/// force, and the contact with the geometry takes the complete budget of a tick. The server is
/// silent for some time, and then sends all answers at once.
class LyingServer {
 public:
  /// `surfaces`: the version of the surfaces that the client has. 0: none.
  LyingServer(testing::ScenePeer& peer, std::uint32_t surfaces)
      : peer_(peer), surfaces_(surfaces) {}

  /// Answers until the hand has felt a force for some time after the last stall.
  void lie(const ClockedHand& hand) {
    for (const int stall : kStalls)
      for (const double after : {0.11, 0.31}) {  // [s]
        answer_for(after, hand);
        silence(1e-3 * stall);
      }
    answer_for(0.3, hand);
  }
  double most_felt = 0.0;

 private:
  static constexpr std::size_t kAtOnce = 64;
  void answer_for(double time, const ClockedHand& hand) {
    const Nanoseconds end = monotonic_now() + from_seconds(time);
    while (monotonic_now() < end) {
      if (const auto sample = next()) answer(*sample);
      most_felt = std::max(most_felt, hand.told.load());
    }
  }
  /// Is silent for `time` [s], and then answers the newest samples in turn.
  void silence(double time) {
    std::vector<Sample> unanswered;
    const Nanoseconds end = monotonic_now() + from_seconds(time);
    while (monotonic_now() < end)
      if (const auto sample = next()) unanswered.push_back(*sample);
    const std::size_t count = std::min(unanswered.size(), kAtOnce);
    for (std::size_t n = unanswered.size() - count; n < unanswered.size(); ++n)
      answer(unanswered[n]);
  }
  std::optional<Sample> next() {
    if (!peer_.has_datagram()) return std::nullopt;
    const auto received = peer_.receive();
    if (received.kind != DatagramKind::samples) return std::nullopt;
    return received.batch.samples[0];
  }
  void answer(const Sample& sample) {
    const Vec3 place = sample.pose.position, moved = place - before_;
    before_ = place;
    Reply reply = testing::ScenePeer::reply_to(sample);
    const double size = moved.norm();
    reply.command.elastic = size > 0.0 ? Vec3(8.0 / size * moved) : Vec3(0, 0, 8.0);
    if (surfaces_ != 0) testing::mark_as_touched(reply, surfaces_, place);
    peer_.send(reply);
  }

  testing::ScenePeer& peer_;
  std::uint32_t surfaces_;
  Vec3 before_ = Vec3::Zero();
};

struct Lied {
  double made = 0.0, debt = 0.0;  // [J] from the true motion; from the account
  double felt = 0.0;              // [N] largest force
  // ticks with a stopped contact; ticks that are a period late or more
  std::uint64_t cut = 0, late = 0;
};

Lied lie_to(std::string_view mode, BoundingSide side, const FetchedScene* heavy) {
  testing::ScenePeer peer;
  SessionParameters p;
  p.mode = mode;
  p.side = side;
  p.local_model = side == BoundingSide::client;
  auto hand = std::make_unique<ClockedHand>(stand_in::SimulatedMass{});
  ClockedHand& moved = *hand;
  const auto task = std::make_shared<ServoTask>(
      std::move(hand), std::make_shared<Transport>(peer.session(), p, false), p, ServoOptions{});
  Ring<const FetchedScene*> fetched(2);
  if (heavy != nullptr) fetched.push(heavy);
  task->options.fetched = &fetched;
  task->let_go_after = p.hold_time;  // A busy machine must not end the session.
  task->priority = kServoPriority;   // The thread has the priority of a client.
  ServoThread thread(task);
  LyingServer server(peer, heavy != nullptr ? heavy->surfaces->version() : 0);
  server.lie(moved);
  EXPECT_TRUE(thread.end());
  const ServoStatistics& s = task->servo.statistics();
  const auto& account = task->servo.account();
  const Lied lied{.made = moved.made(),
                  .debt = account ? account->statistics().largest_debt : 0.0,
                  .felt = server.most_felt,
                  .cut = s.local_model.contact_cut,
                  .late = task->result.missed_deadlines};
  if (testing::measures())
    std::printf("%-14.*s %s %s: %.2f N, %.2e J made, %llu cut, %llu late ticks, debt %.2e J%s\n",
                static_cast<int>(mode.size()), mode.data(),
                side == BoundingSide::client ? "client" : "server",
                heavy != nullptr ? "heavy" : "light", moved.largest_force(), lied.made,
                static_cast<unsigned long long>(lied.cut),
                static_cast<unsigned long long>(lied.late), lied.debt,
                task->servo.overdraft() ? ", which ended the force" : "");
  return lied;
}

TEST(Stall, OfALyingServerGivesTheHandNoEnergy) {
  FetchedScene heavy{.objects = {0},
                     .surfaces = mesh_surfaces(5, {test::through_a_point(20'000)}),
                     .body = nullptr};
  heavy.most_work = units_within(contact_budget(1e-3));
  for (const Law& law : kLaws)
    for (const bool heavily : {false, true}) {
      // Such a session has no local model.
      if (heavily && law.side == BoundingSide::server) continue;
      const Lied lied = lie_to(law.mode, law.side, heavily ? &heavy : nullptr);
      // A machine that delays the thread causes debts, which end the force.
      EXPECT_LE(lied.made, kRounding + (lied.late > 0 ? lied.debt : 0.0)) << law.name << heavily;
      EXPECT_GT(lied.felt, 0.05) << law.name << ' ' << heavily;
      EXPECT_EQ(lied.cut > 0, heavily) << law.name;
    }
}

/// This shows that the measurement can fail.
TEST(Stall, WithoutAnAccountItWould) {
  EXPECT_GT(lie_to(kUnbounded, BoundingSide::client, nullptr).made, 1e-3);
}

}  // namespace
}  // namespace feltwire::stall_test
