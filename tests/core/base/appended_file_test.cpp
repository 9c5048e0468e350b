// Tests a file with a person's data. Only its owner may read it.

#include "core/base/appended_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace feltwire::appended_file_test {
namespace {

namespace fs = std::filesystem;

unsigned mode_of(const fs::path& path) {
  return static_cast<unsigned>(fs::status(path).permissions());
}

TEST(AppendedFile, IsForItsOwnerAlone) {
  const test::TemporaryFolder folder;
  const mode_t before = ::umask(0);
  AppendedFile(folder / "new", "the recording", "--record").append("hand");
  ::umask(before);
  EXPECT_EQ(mode_of(folder / "new"), 0600u);
}

TEST(AppendedFile, ClosesToOthersOneThatWasOpenToThem) {
  const test::TemporaryFolder folder;
  for (const unsigned mode : {0644u, 0666u, 0640u, 0604u}) {
    std::ofstream(folder / "old") << "of another run, which was longer than this one";
    fs::permissions(folder / "old", fs::perms(mode));
    AppendedFile(folder / "old", "the recording", "--record").append("hand");
    EXPECT_EQ(mode_of(folder / "old"), mode & 0700u);
    EXPECT_EQ(fs::file_size(folder / "old"), 4u);
  }
}

/// The mode of a pipe or a device must stay unchanged.
TEST(AppendedFile, LeavesADeviceAsItIs) {
  const auto before = mode_of("/dev/null");
  AppendedFile("/dev/null", "the recording", "--record").append("hand");
  EXPECT_EQ(mode_of("/dev/null"), before);
}

}  // namespace
}  // namespace feltwire::appended_file_test
