#include "client/recording.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "client/devices/replay.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::recording_test {
namespace {

using testing::text_of;

TEST(RecordingFile, HoldsWholeLinesAfterEachBatchAndReplays) {
  testing::TemporaryFolder folder;
  const auto path = folder / "run.csv";
  Ring<TickRecord> rows(8);
  RecordingFile file(path);
  EXPECT_EQ(text_of(path), "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n");

  rows.push({.time = 0.0, .position = {0.01, -0.02, 1e-7}});
  rows.push({.time = 0.001,
             .position = {0.011, -0.02, 0.0},
             .elastic = {0, 0, 2.5},
             .frictional = {-0.5, 0, 0},
             .held = {-0.25, 0, 1.25},
             .age = 0.0005});
  file.write(rows);
  // Read while the file is still open, as after a kill.
  EXPECT_EQ(text_of(path),
            "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n"
            "0,0.01,-0.02,1e-07,0,0,0,0,0,0,0,0,0,-1\n"
            "0.001,0.011,-0.02,0,0,0,2.5,-0.5,0,0,-0.25,0,1.25,0.0005\n");
  EXPECT_EQ(file.rows(), 2u);

  std::ifstream in(path);
  const Recording recording = read_recording(in, "run.csv");
  EXPECT_EQ(recording.poses.size(), 2u);
  EXPECT_EQ(recording.poses[1].pose.position, Vec3(0.011, -0.02, 0.0));
}

TEST(RecordingFile, SaysWhyItCannotBeWritten) {
  EXPECT_THAT(testing::error_of<std::runtime_error>([] { RecordingFile("/nowhere/at/all.csv"); }),
              ::testing::HasSubstr("/nowhere/at/all.csv: No such file or directory"));
}

TEST(RecordingFile, AFullDiskIsSaid) {
  Ring<TickRecord> rows(2);
  EXPECT_THAT(testing::error_of<std::runtime_error>([&] { RecordingFile file("/dev/full"); }),
              ::testing::HasSubstr("No space left"));
}

}  // namespace
}  // namespace feltwire::recording_test
