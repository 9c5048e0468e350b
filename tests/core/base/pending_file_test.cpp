// Replaces a file in one step, on a system that interrupts calls, writes in part, or has a full
// disk.

#include "core/base/pending_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>

#include "tests/client/temporary_folder.hpp"

namespace feltwire::pending_file_test {
namespace {

bool interrupting = false;  // Every second call is interrupted, and a write accepts three bytes.
bool interrupted_last = false;
int folders_synchronized = 0;

bool interrupts() {
  if (!interrupting) return false;
  interrupted_last = !interrupted_last;
  if (interrupted_last) errno = EINTR;
  return interrupted_last;
}

}  // namespace
}  // namespace feltwire::pending_file_test

namespace test_of = feltwire::pending_file_test;

// These functions replace the C library's functions in this program.
extern "C" ssize_t write(int descriptor, const void* data, std::size_t size) {
  if (test_of::interrupts()) return -1;
  if (test_of::interrupting && size > 3) size = 3;
  return ::syscall(SYS_write, descriptor, data, size);
}
extern "C" int fsync(int descriptor) {
  if (test_of::interrupts()) return -1;
  struct stat status {};
  if (::fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode)) ++test_of::folders_synchronized;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace feltwire::pending_file_test {
namespace {

namespace fs = std::filesystem;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::text_of;

mode_t mode_of(const fs::path& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0) << file;
  return status.st_mode & 0777u;
}

/// Sets the umask of this process. The destructor restores it.
class Umask {
 public:
  explicit Umask(mode_t mask) : before_(::umask(mask)) {}
  ~Umask() { ::umask(before_); }
  Umask(const Umask&) = delete;
  Umask& operator=(const Umask&) = delete;

 private:
  mode_t before_;
};

TEST(PendingFile, IsBesideUntilItIsPutInPlace) {
  const TemporaryFolder folder;
  const fs::path file = folder / "state";
  std::ofstream(file) << "old";
  PendingFile pending(file, "new", kPrivate);
  EXPECT_EQ(text_of(file), "old");
  EXPECT_EQ(folder.entries(), 2u);
  const int before = folders_synchronized;
  pending.put_in_place();
  EXPECT_EQ(text_of(file), "new");
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_EQ(folders_synchronized, before + 1);
}

TEST(PendingFile, LeavesNothingWhereItIsNotPutInPlace) {
  const TemporaryFolder folder;
  { const PendingFile pending(folder / "state", "new", kPrivate); }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(PendingFile, OfTwoWritersTheLastOneStands) {
  const TemporaryFolder folder;
  const fs::path file = folder / "state";
  PendingFile first(file, "first", kPrivate), second(file, "second", kPrivate);
  second.put_in_place();
  EXPECT_EQ(text_of(file), "second");
  first.put_in_place();
  EXPECT_EQ(text_of(file), "first");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(PendingFile, HasTheModeThatIsAskedForWhateverTheUmask) {
  const TemporaryFolder folder;
  for (const mode_t mask : {0000u, 0022u, 0077u}) {
    const Umask umask(mask);
    replace_file(folder / "private", "key", kPrivate);
    replace_file(folder / "public", "certificate", kPublic);
    replace_file(folder / "report", "{}", kByUmask);
    EXPECT_EQ(mode_of(folder / "private"), 0600u);
    EXPECT_EQ(mode_of(folder / "public"), 0644u);
    EXPECT_EQ(mode_of(folder / "report"), 0644u & ~mask);
  }
}

TEST(PendingFile, IsWholeWhereTheSystemInterrupts) {
  const TemporaryFolder folder;
  interrupting = true;
  replace_file(folder / "state", "written in small parts", kPrivate);
  interrupting = false;
  EXPECT_EQ(text_of(folder / "state"), "written in small parts");
}

TEST(PendingFile, WithoutRoomLeavesTheOldText) {
  const TemporaryFolder folder;
  const fs::path file = folder / "state";
  std::ofstream(file) << "old";
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{16, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string said =
      error_of<FileError>([&] { replace_file(file, std::string(100, 'x'), kPrivate); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(said, HasSubstr("cannot write " + file.string() + ": File too large"));
  EXPECT_EQ(text_of(file), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(PendingFile, ReplacesOnlyRegularFiles) {
  const TemporaryFolder folder;
  const fs::path pipe = folder / "pipe", taken = folder / "folder";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_directory(taken);
  EXPECT_THAT(error_of<FileError>([&] { PendingFile(pipe, "text", kPrivate); }),
              HasSubstr(pipe.string() + ": it is not a regular file"));
  EXPECT_THAT(error_of<FileError>([&] { PendingFile(taken, "text", kPrivate); }),
              HasSubstr(taken.string() + ": it is a directory"));
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(folder.entries(), 2u);
}

/// Temporary files of other names must stay.
TEST(PendingFile, LeftoversOfOneFileAreRemoved) {
  const TemporaryFolder folder;
  for (const char* name : {"state", "state.part-000000", "state.part-a9Xk2Z", "state.part-1",
                           "state.part-0000001", "other.part-000000", "mystate.part-000000"})
    std::ofstream(folder / name) << "text";
  remove_leftovers(folder / "state");
  EXPECT_EQ(folder.entries(), 5u);
  EXPECT_FALSE(fs::exists(folder / "state.part-000000"));
  EXPECT_FALSE(fs::exists(folder / "state.part-a9Xk2Z"));
  EXPECT_TRUE(fs::exists(folder / "state"));
}

}  // namespace
}  // namespace feltwire::pending_file_test
