#include "client/hands/replay_device.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "core/base/csv.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::replay_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Recording recording(const std::string& text) {
  std::istringstream in(text);
  return read_recording(in, "r.csv");
}
std::string complaint(const std::string& text) {
  return testing::error_of<CsvError>([&] { recording(text); });
}
Nanoseconds seconds(double s) { return Nanoseconds(std::llround(s * 1e9)); }

TEST(Replay, PositionIsLinearBetweenIrregularRows) {
  ReplayDevice device(recording("t,x,y,z\n5,0,0,1\n5.5,1,-2,1\n7.5,5,2,0\n"),
                      builtin_device("simulated"));
  const Nanoseconds start = seconds(1234.5);
  EXPECT_EQ(device.read(start).pose.position, Vec3(0, 0, 1));
  EXPECT_TRUE(device.read(start + seconds(0.25)).pose.position.isApprox(Vec3(0.5, -1, 1), 1e-12));
  EXPECT_TRUE(device.read(start + seconds(1.0)).pose.position.isApprox(Vec3(2, -1, 0.75), 1e-12));
  const DeviceReading before_end = device.read(start + seconds(2.499));
  EXPECT_FALSE(before_end.ended);
  const DeviceReading end = device.read(start + seconds(2.5));
  EXPECT_TRUE(end.ended);
  EXPECT_EQ(end.pose.position, Vec3(5, 2, 0));
  EXPECT_EQ(device.read(start + seconds(100)).pose.position, Vec3(5, 2, 0));
}

TEST(Replay, OrientationTurnsAtAConstantRate) {
  // A quarter turn about z takes one second. A third of this turn is 30 degrees.
  const double h = std::numbers::sqrt2 / 2.0;
  std::ostringstream text;
  text.precision(17);
  text << "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0," << -h << ",0,0," << -h
       << "\n";  // The quaternions q and -q are the same orientation.
  ReplayDevice device(recording(text.str()), builtin_device("touch"));
  EXPECT_EQ(device.spec().rotation_sensed, 3);
  EXPECT_TRUE(device.read(seconds(0)).pose.orientation.isApprox(Quaternion::Identity()));
  const Quaternion third = device.read(seconds(1.0 / 3.0)).pose.orientation;
  const Vec3 turned = rotation_between(Quaternion::Identity(), third);
  EXPECT_NEAR(turned.z(), std::numbers::pi / 6.0, 1e-8);
  EXPECT_NEAR(turned.head<2>().norm(), 0.0, 1e-12);
}

TEST(Replay, SensesRotationExactlyWhenItWasRecorded) {
  const ReplayDevice device(recording("t,x,y,z\n0,0,0,0\n"), builtin_device("touch"));
  EXPECT_EQ(device.spec().rotation_sensed, 0);
  EXPECT_NO_THROW(validate(device.spec()));
}

TEST(Replay, CursorMayGoBack) {
  const Recording r = recording("t,x,y,z\n0,0,0,0\n1,1,0,0\n2,3,0,0\n");
  std::size_t cursor = 0;
  EXPECT_DOUBLE_EQ(pose_at(r, 1.5, cursor).position.x(), 2.0);
  EXPECT_DOUBLE_EQ(pose_at(r, 0.5, cursor).position.x(), 0.5);
  EXPECT_DOUBLE_EQ(pose_at(r, 1.0, cursor).position.x(), 1.0);
}

TEST(Replay, ErrorsNameTheLineAndTheColumn) {
  EXPECT_THAT(complaint("t,x,y\n0,0,0\n"), StartsWith("r.csv:1: column 'z'"));
  EXPECT_THAT(complaint("t,x,y,z\n"), StartsWith("r.csv:1: there are no rows"));
  EXPECT_THAT(complaint("t,x,y,z\n0,0,0,0\n0.1,0,zero,0\n"),
              StartsWith("r.csv:3: column 'y': 'zero' is not a number"));
  EXPECT_THAT(complaint("t,x,y,z\n0,0,0,nan\n"),
              StartsWith("r.csv:2: column 'z': 'nan' is not finite"));
  EXPECT_THAT(complaint("t,x,y,z\n0,0,0,0\n1,0,0,0\n1,0,0,0\n"),
              StartsWith("r.csv:4: column 't': time must rise"));
  EXPECT_THAT(complaint("t,x,y,z\n1,0,0,0\n0,0,0,0\n"),
              StartsWith("r.csv:3: column 't': time must rise"));
  EXPECT_THAT(complaint("t,x,y,z,qw,qx,qy\n0,0,0,0,1,0,0\n"), HasSubstr("all four or none"));
  EXPECT_THAT(complaint("t,x,y,z,qx,qy,qz\n0,0,0,0,0,0,0\n"), HasSubstr("all four or none"));
  EXPECT_THAT(complaint("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n"),
              StartsWith("r.csv:2: column 'qw'"));
}

TEST(Replay, NumbersThatNoMovementHasAreRefused) {
  // Differences between such positions or times overflow a double.
  EXPECT_THAT(complaint("t,x,y,z\n0,0,-1e308,0\n1,0,1e308,0\n"),
              AllOf(StartsWith("r.csv:2: column 'y': "), HasSubstr("1000 m")));
  EXPECT_THAT(complaint("t,x,y,z\n-1e308,0,0,0\n1e308,0,0,0\n"),
              AllOf(StartsWith("r.csv:2: column 't': "), HasSubstr("1e10 s")));
  // The loader must accept seconds since 1970 and the largest coordinate of a sample.
  EXPECT_EQ(recording("t,x,y,z\n1.8e9,1000,-1000,0\n").poses.size(), 1u);
}

TEST(Replay, AMissingFileIsOneClearLine) {
  const std::string text = testing::error_of<CsvError>(
      [] { make_replay_device("/proc/nowhere/hand.csv", builtin_device("simulated")); });
  EXPECT_THAT(text,
              StartsWith("/proc/nowhere/hand.csv: cannot be opened: No such file or directory"));
}

/// The loader must not block. It must refuse a pipe without a writer and a device with endless
/// data.
TEST(Replay, OnlyRegularFilesAreRead) {
  const testing::TemporaryFolder folder;
  const auto pipe = folder / "hand.csv";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto error = [](const std::filesystem::path& file) {
    return testing::error_of<CsvError>(
        [&] { make_replay_device(file, builtin_device("simulated")); });
  };
  EXPECT_EQ(error(pipe), pipe.string() + ": is a pipe; name a regular file");
  EXPECT_EQ(error("/dev/zero"), "/dev/zero: is a device; name a regular file");
  const auto huge = folder / "huge.csv";
  std::ofstream(huge) << "t,x,y,z\n";
  std::filesystem::resize_file(huge, std::uintmax_t{1} << 40);
  EXPECT_EQ(error(huge), huge.string() + ": is larger than 512 MiB; is it the right file?");
}

}  // namespace
}  // namespace feltwire::replay_test
