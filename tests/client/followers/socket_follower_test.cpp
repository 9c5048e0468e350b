// Tests a robot driver in another program: its lines and its failures.

#include "client/followers/socket_follower.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include "protocol/net/clock.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::socket_follower_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr Nanoseconds kSoon = std::chrono::seconds(20);
const std::string kHello = "follower 1 name=arm period=0.005 stiffness=800\n";

/// The driver's end of the socket.
class Driver {
 public:
  explicit Driver(const std::filesystem::path& path)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("cannot connect to " + path.string());
  }
  ~Driver() { hang_up(); }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  void say(const std::string& text) const {
    ASSERT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  void state(int number, double x, const std::string& more = "") const {
    const std::string place = std::to_string(x) + ",0,0,1,0,0,0";
    say("state " + std::to_string(number) + " pose=" + place + " commanded=" + place + more + "\n");
  }
  /// Returns all text received so far.
  std::string heard() const {
    std::string text(1 << 16, '\0');
    const ssize_t count = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }
  void hang_up() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

 private:
  int socket_;
};

class SocketFollowerTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "driver"; }
  std::unique_ptr<SocketFollower> joined() {
    driver_.say(kHello);
    auto follower = listener_.wait(kSoon);
    EXPECT_EQ(driver_.heard(), "welcome 1\n");
    return follower;
  }
  static FollowerTarget target_at(double x) {
    FollowerTarget target;
    target.pose.position.x() = x;
    return target;
  }

  test::TemporaryFolder folder_;
  FollowerListener listener_{path()};
  Driver driver_{path()};
};

TEST_F(SocketFollowerTest, StatesComeInAndTargetsGoOut) {
  const auto follower = joined();
  EXPECT_EQ(follower->spec().stiffness, 800.0);
  EXPECT_FALSE(follower->read(milliseconds(0)).ok);
  // Before the first state the robot's position is unknown. The follower must send nothing.
  follower->write(target_at(5.0));
  EXPECT_EQ(driver_.heard(), "");
  driver_.state(1, 0.5, " force=1,2,3");
  driver_.state(2, 0.6);
  const FollowerReading reading = follower->read(milliseconds(5));
  EXPECT_TRUE(reading.ok);
  EXPECT_EQ(reading.pose.position.x(), 0.6) << "the newest counts";
  EXPECT_FALSE(reading.force);
  const FollowerTarget held = follower->write(target_at(0.7));
  EXPECT_EQ(held.pose.position.x(), 0.7);
  EXPECT_EQ(driver_.heard(), "target 1 pose=0.7,0,0,1,0,0,0 gripper=0\n");
}

TEST_F(SocketFollowerTest, ASilentDriverIsNotOkUntilItSpeaks) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  EXPECT_TRUE(follower->read(milliseconds(1000)).ok);
  EXPECT_TRUE(follower->read(milliseconds(1100)).ok);
  EXPECT_FALSE(follower->read(milliseconds(1101)).ok);
  // The target is the position that the robot reported.
  EXPECT_EQ(follower->write(target_at(0.9)).pose.position.x(), 0.5);
  driver_.state(2, 0.5);
  EXPECT_TRUE(follower->read(milliseconds(1105)).ok);
  EXPECT_EQ(follower->write(target_at(0.6)).pose.position.x(), 0.6);
}

TEST_F(SocketFollowerTest, ALineWithAFaultIsNotUsedAndIsNamed) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  driver_.say("state 2 pose=0,0,nan,1,0,0,0 commanded=0,0,0,1,0,0,0\n");
  EXPECT_EQ(follower->read(milliseconds(0)).pose.position.x(), 0.5);
  EXPECT_THAT(driver_.heard(), StartsWith("error 3: pose: is no seven finite numbers"));
  driver_.state(1, 0.9);
  EXPECT_EQ(follower->read(milliseconds(5)).pose.position.x(), 0.5) << "an old state";
  EXPECT_THAT(driver_.heard(), HasSubstr("error 4: state: has a number that is not above"));
  driver_.say(std::string(5000, 'x'));
  EXPECT_TRUE(follower->read(milliseconds(5)).ok);
  EXPECT_THAT(driver_.heard(), StartsWith("error 5: line: is longer"));
  driver_.say("\x1b[2J\xff\n");
  driver_.say("\x1b[2J\xff\n");
  follower->read(milliseconds(5));
  EXPECT_THAT(driver_.heard(), HasSubstr("state: is not the first word"));
  EXPECT_EQ(follower->faults(), 4u);
}

TEST_F(SocketFollowerTest, AStoppedDriverKeepsItsOwnTarget) {
  const auto follower = joined();
  driver_.state(1, 0.5, " stopped=1");
  const FollowerReading reading = follower->read(milliseconds(0));
  EXPECT_TRUE(reading.ok);
  EXPECT_TRUE(reading.stopped);
  EXPECT_EQ(follower->write(target_at(0.9)).pose.position.x(), 0.5);
}

TEST_F(SocketFollowerTest, ATargetThatIsNotFiniteIsNotSent) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  follower->read(milliseconds(0));
  follower->write(target_at(0.6));
  driver_.heard();
  FollowerTarget bad = target_at(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(follower->write(bad).pose.position.x(), 0.6);
  EXPECT_THAT(driver_.heard(), HasSubstr("pose=0.6,"));
}

TEST_F(SocketFollowerTest, HoldIsSaidAtOnceAndNothingAfterIt) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  follower->read(milliseconds(0));
  follower->hold();
  EXPECT_THAT(driver_.heard(), HasSubstr("\nhold\n"));
  EXPECT_EQ(follower->write(target_at(0.9)).pose.position.x(), 0.5);
  EXPECT_EQ(driver_.heard(), "");
}

TEST_F(SocketFollowerTest, ADriverThatHangsUpIsNotOk) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  EXPECT_TRUE(follower->read(milliseconds(0)).ok);
  driver_.hang_up();
  EXPECT_FALSE(follower->read(milliseconds(1)).ok);
  follower->write(target_at(0.6));  // Without a driver this call has no effect.
  follower->hold();
}

TEST_F(SocketFollowerTest, ADriverThatDoesNotReadGetsFewOldTargetsAndWholeLines) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  follower->read(milliseconds(0));
  for (int i = 0; i < 10000; ++i) follower->write(target_at(1e-4 * i));
  std::string text = driver_.heard();
  const auto lines = [](const std::string& t) { return std::count(t.begin(), t.end(), '\n'); };
  EXPECT_LT(lines(text), 100);
  driver_.state(2, 0.5);
  follower->read(milliseconds(5));
  follower->write(target_at(0.75));
  text += driver_.heard();
  ASSERT_THAT(text, ::testing::EndsWith("pose=0.75,0,0,1,0,0,0 gripper=0\n"));
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    EXPECT_EQ(text.compare(at, 7, "target "), 0) << text.substr(at, 40);
}

TEST_F(SocketFollowerTest, AHoldThatFindsNoRoomIsSaidAsSoonAsThereIsSome) {
  const auto follower = joined();
  driver_.state(1, 0.5);
  follower->read(milliseconds(0));
  for (int i = 0; i < 10000; ++i) follower->write(target_at(1e-4 * i));
  follower->hold();
  follower->read(milliseconds(1));
  std::string text = driver_.heard();
  EXPECT_THAT(text, ::testing::Not(HasSubstr("hold")));
  follower->read(milliseconds(2));
  follower->read(milliseconds(3));
  text += driver_.heard();
  EXPECT_THAT(text, ::testing::EndsWith("\nhold\n"));
}

TEST_F(SocketFollowerTest, AllocatesNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers bring their own allocator";
#endif
  const auto follower = joined();
  driver_.state(1, 0.5, " force=1,2,3");
  driver_.say("nonsense\n");
  const std::size_t before = test::allocations();
  follower->read(milliseconds(0));
  follower->write(target_at(0.6));
  follower->hold();
  EXPECT_EQ(test::allocations() - before, 0u);
}

/// The servo waits for read(). One read must take only a part of a flood and answer only some
/// faults.
TEST_F(SocketFollowerTest, ADriverThatWritesOnlyFaultsGetsFewAnswersAtATime) {
  const auto follower = joined();
  constexpr std::uint64_t kLines = 10'000;
  std::string lines;
  for (std::uint64_t i = 0; i < kLines; ++i) lines += "x\n";
  driver_.say(lines);
  follower->read(milliseconds(0));
  EXPECT_EQ(follower->faults(), std::uint64_t{SocketFollower::kMostFaults});
  const std::string heard = driver_.heard();
  EXPECT_EQ(std::count(heard.begin(), heard.end(), '\n'), SocketFollower::kMostAnswers);
  // A later read must take the state that follows the flood.
  driver_.state(1, 0.5);
  for (std::uint64_t i = 0; i <= kLines / SocketFollower::kMostFaults; ++i)
    follower->read(milliseconds(0));
  EXPECT_EQ(follower->faults(), kLines);
  EXPECT_TRUE(follower->read(milliseconds(0)).ok);
}

TEST_F(SocketFollowerTest, ADriverThatNeverSaysHelloIsRefused) {
  driver_.say(std::string(FollowerListener::kMostBeforeHello + 1, '\n'));
  try {
    listener_.wait(kSoon);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no hello in 65536 bytes"));
  }
}

TEST_F(SocketFollowerTest, AHelloWithAFaultIsToldToBoth) {
  driver_.say("follower 1 name=arm period=0.005 stiffness=-3\n");
  try {
    listener_.wait(kSoon);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("error 1: stiffness: is not above 0"));
  }
  EXPECT_THAT(driver_.heard(), StartsWith("error 1: stiffness: "));
}

TEST_F(SocketFollowerTest, NobodyElseMayConnect) {
  struct stat status {};
  ASSERT_EQ(::stat(path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0600u);
}

TEST(FollowerListenerTest, SaysWhatIsWrongWithAPath) {
  const test::TemporaryFolder folder;
  const auto error_of = [](const std::filesystem::path& path) -> std::string {
    try {
      const FollowerListener listener(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(error_of(std::string(200, 'x')), HasSubstr("give a shorter path"));
  EXPECT_THAT(error_of(folder / "no" / "folder"), HasSubstr("cannot wait for a driver there"));
  std::ofstream(folder / "file") << "text";
  EXPECT_THAT(error_of(folder / "file"), HasSubstr("is no socket; remove it"));
  EXPECT_TRUE(std::filesystem::exists(folder / "file"));
  FollowerListener alone(folder / "alone");
  EXPECT_THROW(alone.wait(milliseconds(1)), std::runtime_error);
}

/// The Python example with its simulated robot must follow the target and touch its floor.
TEST(PythonFollower, FollowsTouchesAndHolds) {
  const test::TemporaryFolder folder;
  FollowerListener listener(folder / "driver");
  const test::Program python(
      "/usr/bin/env",
      {"python3", FELTWIRE_SOURCE_DIR "/examples/my_follower.py", (folder / "driver").string()});
  const auto follower = listener.wait(test::kLongest);
  EXPECT_EQ(follower->spec().name, "my_follower");
  EXPECT_EQ(follower->spec().servo_period, 0.005);
  FollowerReading reading;
  const auto read = [&] { reading = follower->read(monotonic_now()); };
  FollowerTarget target;
  const auto comes = [&](const char* what, auto condition) {
    test::eventually(what, [&] {
      read();
      if (reading.ok) follower->write(target);
      return reading.ok && condition();
    });
  };
  target.pose.position = Vec3(0.02, -0.01, 0.05);
  comes("the robot at its target",
        [&] { return (reading.pose.position - target.pose.position).norm() < 1e-4; });
  EXPECT_LT(reading.force.value_or(Vec3::Ones()).norm(), 1e-9);
  // 30 mm below the floor, with 1 kN/m and 2 kN/m in series.
  target.pose.position.z() = -0.03;
  comes("the floor's force",
        [&] { return std::abs(reading.force.value_or(Vec3::Zero()).z() - 20.0) < 0.1; });
  target.gripper = 0.05;
  comes("the gripper", [&] { return reading.gripper == 0.05; });
  follower->hold();
  test::eventually("the stop", [&] {
    read();
    return reading.stopped;
  });
  EXPECT_EQ(follower->faults(), 0u);
}

}  // namespace
}  // namespace feltwire::socket_follower_test
