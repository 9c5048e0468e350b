// Tests a folder that only its owner may read.

#include "core/base/private_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace feltwire::private_folder_test {
namespace {

namespace fs = std::filesystem;

fs::perms mode_of(const fs::path& path) { return fs::status(path).permissions(); }

TEST(PrivateFolder, IsForItsOwnerAloneAndThoseAboveAreNot) {
  const test::TemporaryFolder place;
  const mode_t before = ::umask(022);
  const std::error_code failed = make_private_folder(place / "above/own");
  const std::error_code closed = make_private_folder(place / "other/");
  ::umask(before);
  EXPECT_FALSE(failed) << failed.message();
  EXPECT_EQ(mode_of(place / "above/own"), fs::perms::owner_all);
  EXPECT_NE(mode_of(place / "above") & fs::perms::others_read, fs::perms::none);
  EXPECT_FALSE(closed) << closed.message();
  EXPECT_EQ(mode_of(place / "other"), fs::perms::owner_all);
}

TEST(PrivateFolder, ThatIsThereStaysAsItIs) {
  const test::TemporaryFolder place;
  const fs::path folder = place / "shared";
  fs::create_directory(folder);
  fs::permissions(folder, fs::perms(0750));
  EXPECT_FALSE(make_private_folder(folder));
  EXPECT_EQ(mode_of(folder), fs::perms(0750));
}

TEST(PrivateFolder, SaysWhatFailed) {
  const test::TemporaryFolder place;
  std::ofstream(place / "file") << "in the way";
  EXPECT_EQ(make_private_folder(place / "file"), std::errc::file_exists);
  EXPECT_EQ(make_private_folder(place / "file/own"), std::errc::not_a_directory);
}

TEST(PrivateFolder, OneThatOthersLookIntoIsNone) {
  const test::TemporaryFolder place;
  EXPECT_EQ(shared_folder(place / "missing"), std::nullopt);
  fs::create_directory(place / "folder");
  for (const unsigned mode : {0755u, 0750u, 0701u, 0770u, 01777u}) {
    fs::permissions(place / "folder", fs::perms(mode));
    const auto wrong = shared_folder(place / "folder");
    ASSERT_TRUE(wrong) << mode;
    EXPECT_NE(wrong->find("; chmod 700 " + (place / "folder").string()), std::string::npos);
  }
  fs::permissions(place / "folder", fs::perms(0700));
  EXPECT_EQ(shared_folder(place / "folder"), std::nullopt);
}

}  // namespace
}  // namespace feltwire::private_folder_test
