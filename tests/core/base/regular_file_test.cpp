#include "core/base/regular_file.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/base/file_error.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::regular_file_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kMost = 1000;

std::string error_of(const std::filesystem::path& file) {
  return testing::error_of<FileError>([&] { read_regular_file(file, kMost, "say which"); });
}

TEST(RegularFile, IsReadByteForByteUpToItsLimit) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "file";
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kMost - 1, kMost}) {
    std::string text(size, '\0');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 7);
    std::ofstream(file, std::ios::binary) << text;
    EXPECT_EQ(read_regular_file(file, kMost), text);
  }
  std::ofstream(file, std::ios::binary) << std::string(kMost + 1, 'x');
  EXPECT_THAT(error_of(file), HasSubstr("is larger than 1000 bytes; is it the right file?"));
}

/// Reading such a file would block or never end.
TEST(RegularFile, PipesDevicesAndFoldersAreRefusedAtOnce) {
  const testing::TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(error_of(pipe), pipe.string() + ": is a pipe; name a regular file");
  EXPECT_EQ(error_of("/dev/zero"), "/dev/zero: is a device; name a regular file");
  EXPECT_EQ(error_of(folder / "."),
            (folder / ".").string() + ": is a directory; name a regular file");
}

/// A sparse file of 1 TB must be refused before it is read.
TEST(RegularFile, AHugeFileIsRefusedByItsSize) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "huge";
  std::ofstream(file) << "x";
  std::filesystem::resize_file(file, std::uintmax_t{1} << 40);
  EXPECT_THAT(error_of(file), HasSubstr("is larger than 1000 bytes"));
}

/// The system reports size 0 for this file, but the file has content.
TEST(RegularFile, WhatTheSystemMakesUpIsReadToItsEnd) {
  EXPECT_THAT(read_regular_file("/proc/self/status", 1 << 20), HasSubstr("VmRSS"));
  EXPECT_THAT(testing::error_of<FileError>([] { read_regular_file("/proc/self/status", 10); }),
              HasSubstr("is larger than 10 bytes"));
}

TEST(RegularFile, WhatIsNotThereIsNamedWithTheRemedy) {
  EXPECT_EQ(error_of("/proc/nowhere/at/all"),
            "/proc/nowhere/at/all: cannot be opened: No such file or directory; say which");
}

}  // namespace
}  // namespace feltwire::regular_file_test
