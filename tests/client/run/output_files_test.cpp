#include "client/run/output_files.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "tests/client/temporary_folder.hpp"

namespace feltwire::output_files_test {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::text_of;

TEST(WriteWhole, ReplacesInOneStepAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  const auto file = folder / "report.json";
  write_whole(file, "old");
  struct stat before, after;
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  std::ifstream reader(file);  // This stream was opened earlier and must still read the old text.
  write_whole(file, "new and longer");
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_NE(before.st_ino, after.st_ino);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "old");
  EXPECT_EQ(text_of(file), "new and longer");
  EXPECT_EQ(folder.entries(), 1u);
}

/// A report contains personal data. Only its owner may read it, independent of the old mode and the
/// umask.
TEST(WriteWhole, IsForItsOwnerAlone) {
  const TemporaryFolder folder;
  const auto file = folder / "report.json";
  const mode_t before = ::umask(0);
  write_whole(file, "old");
  std::filesystem::permissions(file, std::filesystem::perms(0644));
  write_whole(file, "new");
  ::umask(before);
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms(0600));
}

TEST(WriteWhole, FollowsLinks) {
  const TemporaryFolder folder;
  write_whole(folder / "real.json", "old");
  std::filesystem::create_symlink(folder / "real.json", folder / "link.json");
  write_whole(folder / "link.json", "new");
  EXPECT_EQ(text_of(folder / "real.json"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.json"));
}

/// The write must keep a link to a missing file, and create this file.
TEST(WriteWhole, FollowsLinksToFilesThatAreYetToBe) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("real.json", folder / "link.json");
  check_writable(folder / "link.json");
  write_whole(folder / "link.json", "new");
  EXPECT_EQ(text_of(folder / "real.json"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.json"));
}

TEST(WriteWhole, WritesIntoWhatIsNoRegularFile) {
  const TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  check_writable(pipe);
  write_whole(pipe, "text");
  char buffer[16];
  EXPECT_EQ(::read(reader, buffer, sizeof buffer), 4);
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(CheckWritable, TellsBeforeTheRunAndTouchesNothing) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of<std::runtime_error>([&] { check_writable(folder / "no/such/report.json"); }),
              HasSubstr("no/such/report.json: No such file or directory"));
  EXPECT_THAT(error_of<std::runtime_error>([&] { check_writable(folder / "."); }),
              HasSubstr("directory"));
  write_whole(folder / "there.json", "kept");
  check_writable(folder / "there.json");
  check_writable(folder / "new.json");
  EXPECT_EQ(text_of(folder / "there.json"), "kept");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace feltwire::output_files_test
