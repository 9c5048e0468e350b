#include "client/run/recording.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "client/hands/replay_device.hpp"
#include "client/run/records.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::recording_test {
namespace {

using testing::text_of;

TEST(CsvRecording, HoldsWholeLinesAfterEachBatchAndReplays) {
  testing::TemporaryFolder folder;
  const auto path = folder / "run.csv";
  Ring<TickRecord> rows(8);
  CsvRecording file(path);
  EXPECT_EQ(text_of(path), "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n");

  rows.push({.time = 0.0, .position = {0.01, -0.02, 1e-7}});
  rows.push({.time = 0.001,
             .position = {0.011, -0.02, 0.0},
             .elastic = {0, 0, 2.5},
             .frictional = {-0.5, 0, 0},
             .held = {-0.25, 0, 1.25},
             .age = 0.0005});
  file.write(rows);
  // The test reads the open file, as after a kill of the program.
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

TEST(CsvRecording, SaysWhyItCannotBeWritten) {
  EXPECT_THAT(
      testing::error_of<std::runtime_error>([] { CsvRecording("/proc/nowhere/at/all.csv"); }),
      ::testing::HasSubstr("/proc/nowhere/at/all.csv: No such file or directory"));
}

TEST(CsvRecording, AFullDiskIsSaid) {
  Ring<TickRecord> rows(2);
  EXPECT_THAT(testing::error_of<std::runtime_error>([&] { CsvRecording file("/dev/full"); }),
              ::testing::HasSubstr("No space left"));
}

/// Limits the size of files, as a full disk does.
class FullDisk {
 public:
  explicit FullDisk(rlim_t most) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit less{most, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &less);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, SIG_DFL);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

/// The disk may be full anywhere in a line. The rest of the file must be replayable.
TEST(CsvRecording, OnAFullDiskEndsWithAWholeLine) {
  const testing::TemporaryFolder folder;
  for (rlim_t most = 100; most < 190; ++most) {
    const auto path = folder / "run.csv";
    Ring<TickRecord> rows(8);
    std::string error;
    {
      const FullDisk disk(most);
      CsvRecording file(path);
      for (int i = 0; i < 8; ++i) rows.push({.time = 0.001 * i, .position = {0.01, -0.02, 0.25}});
      error = testing::error_of<std::runtime_error>([&] { file.write(rows); });
    }
    ASSERT_THAT(error, ::testing::HasSubstr("run.csv ends here: File too large; make room"));
    const std::string text = text_of(path);
    ASSERT_EQ(text.back(), '\n') << most;
    std::ifstream in(path);
    const std::size_t replayed = read_recording(in, "run.csv").poses.size();
    ASSERT_EQ(replayed, static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) - 1);
    ASSERT_GT(replayed, 0u);
  }
}

/// The program must name the failing file once and continue the other file.
TEST(Records, OneFileThatFailsDoesNotEndTheOther) {
  const testing::TemporaryFolder folder;
  std::FILE* said = std::tmpfile();
  {
    Records records({.recording = RecordingTarget{folder / "run.csv"},
                     .view = folder / "seen.csv",
                     .observes = true},
                    said);
    Ring<TickRecord>* const rows = records.rows();
    ASSERT_NE(rows, nullptr);
    {
      const FullDisk disk(60);
      for (int i = 0; i < 4; ++i) rows->push(TickRecord{});
      records.write();
      EXPECT_TRUE(records.failed());
    }
    SceneView view;
    view.present = true;
    view.hands_end = SceneView::kLastHand;
    view.hand[view.hand_count++].number = 7;
    records.views()->push({0.5, view});
    rows->push(TickRecord{});
    records.write();
    records.finish();
    EXPECT_EQ(records.sight()->hands, 1u);
  }
  EXPECT_THAT(text_of(folder / "seen.csv"), ::testing::HasSubstr("0.5,hand,7,"));
  std::rewind(said);
  char line[512];
  ASSERT_NE(std::fgets(line, sizeof line, said), nullptr);
  EXPECT_THAT(line, ::testing::HasSubstr("run.csv ends here: File too large"));
  EXPECT_EQ(std::fgets(line, sizeof line, said), nullptr);  // The error appears only once.
  std::fclose(said);
}

}  // namespace
}  // namespace feltwire::recording_test
