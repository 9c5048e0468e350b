// A file stores the convex parts of a mesh. The scene must not depend on the file's content.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <thread>

#include "core/base/cancellation.hpp"
#include "core/convex/convex_parts_file.hpp"
#include "core/convex/decomposition.hpp"
#include "tests/core/scene_file/parts_scene.hpp"

namespace feltwire::parts_cache_test {
namespace {

using test::mesh_text;
using test::text_of;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

namespace fs = std::filesystem;

class PartsCache : public test::PartsScene {
 protected:
  PartsCache() { write("ring.obj", test::torus(0.05, 0.015, 7, 5)); }

  Scene ring(const std::string& in_mesh = "") const { return ring_of("ring.obj", in_mesh); }
  Scene ring_of(const std::string& file, const std::string& in_mesh = "") const {
    return scene(R"({ "name": "b", "mass": 1 })",
                 mesh_text("o", file, in_mesh, R"(, "body": "b")"));
  }
  std::string wrong(const std::string& parts) const {
    return error_of(
        R"({ "name": "b", "mass": 1 })",
        mesh_text("o", "ring.obj", R"(, "convex_parts": )" + parts, R"(, "body": "b")"));
  }
  fs::path beside() const { return scenes() / "ring.obj.m.auto.64.convex"; }
};

TEST_F(PartsCache, IsBesideTheMeshOneFileForEachUseOfIt) {
  ring();
  EXPECT_THAT(kept_in(scenes()), ElementsAre(beside()));
  struct stat status {};
  ASSERT_EQ(::stat(beside().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0022, 0u);
  ring(R"(, "convex_parts": { "tolerance": 0.004, "most": 20 })");
  EXPECT_THAT(kept_in(scenes()), ElementsAre(scenes() / "ring.obj.m.0.004.20.convex", beside()));
  // Another mesh replaces the mesh's file.
  write("ring.obj", test::torus(0.05, 0.014, 7, 5));
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("is of another mesh")));
  EXPECT_EQ(kept_in(scenes()).size(), 2u);
  EXPECT_THAT(ring().notes(), ElementsAre(HasSubstr("read from")));
  EXPECT_FALSE(fs::exists(user_cache()));
}

TEST_F(PartsCache, ADamagedOrForeignFileIsSaidAndMadeAnew) {
  ring();
  const std::string bytes = text_of(beside());
  ASSERT_GT(bytes.size(), 500u);
  std::string flipped = bytes;
  flipped[bytes.size() / 2] ^= 4;
  const MeshSurface other(TriangleMesh(test::torus(0.06, 0.015, 7, 5)));
  const std::string foreign =
      convex_parts_bytes(convex_parts(other, {}), parts_key(other.mesh(), {}));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "is no file of convex parts"},
      {"FWPARTS1", "has a length"},
      {bytes.substr(0, bytes.size() / 2), "is damaged"},
      {bytes.substr(0, bytes.size() - 1), "is damaged"},
      {bytes + "x", "is damaged"},
      {flipped, "is damaged"},
      {foreign, "is of another mesh"},
      {std::string(300, '\xff'), "is no file"}};
  for (const auto& [content, why] : cases) {
    write(beside().filename(), content);
    EXPECT_THAT(ring().notes(), AllOf(Contains(AllOf(HasSubstr(beside().string()), HasSubstr(why),
                                                     HasSubstr("it is not used"))),
                                      Contains(HasSubstr("computed in"))));
    EXPECT_EQ(text_of(beside()), bytes) << why;
  }
  // The file is larger than the limit. The loader must not read it to its end.
  fs::resize_file(beside(), kMostConvexPartsFile + 1);
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("is larger than 64 MiB")));
  EXPECT_EQ(text_of(beside()), bytes);
}

TEST_F(PartsCache, WhatIsNoRegularFileIsNeitherReadNorReplaced) {
  ring();
  const std::string bytes = text_of(beside());
  const fs::path away = folder / "away";
  fs::rename(beside(), away);
  fs::create_symlink(away, beside());
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("is not a regular file")));
  // The loader must replace the link instead of its target.
  EXPECT_FALSE(fs::is_symlink(beside()));
  EXPECT_EQ(text_of(away), bytes);
  fs::remove(beside());
  ASSERT_EQ(::mkfifo(beside().c_str(), 0600), 0);  // The loader must not wait for a writer.
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("is not a regular file")));
  EXPECT_TRUE(fs::is_fifo(beside()));
  EXPECT_THAT(kept_in(user_cache()), ElementsAre(::testing::_));
}

// A folder has the file's name. Even root cannot write the file.
TEST_F(PartsCache, WithoutARightToWriteTheUsersFolderHasIt) {
  fs::create_directory(beside());
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("kept in " + user_cache().string())));
  struct stat status {};
  ASSERT_EQ(::stat(user_cache().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  const auto kept = kept_in(user_cache());
  ASSERT_EQ(kept.size(), 1u);
  ASSERT_EQ(::stat(kept[0].c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("read from " + user_cache().string())));
  // The user's folder is not writable either. The load must continue without a file and name the
  // remedy.
  fs::remove_all(user_cache());
  fs::create_directories(user_cache().parent_path());
  std::ofstream(user_cache()) << "a file";
  EXPECT_THAT(ring().notes(), AllOf(Contains(HasSubstr("computed anew at each start; let the")),
                                    Contains(HasSubstr("cannot write " + beside().string()))));
  ::unsetenv("XDG_CACHE_HOME");
  ::setenv("HOME", "not/absolute", 1);
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("computed anew at each start")));
}

TEST_F(PartsCache, AFileOfSomebodyElseIsNotRead) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root may give files away";
  ring();
  constexpr uid_t kOther = 12345;
  ASSERT_EQ(::chown(beside().c_str(), kOther, kOther), 0);
  EXPECT_THAT(ring().notes(), Contains(HasSubstr("belongs to somebody else")));
  // The mesh's owner may also own the file of its parts.
  ASSERT_EQ(::chown(beside().c_str(), kOther, kOther), 0);
  ASSERT_EQ(::chown((scenes() / "ring.obj").c_str(), kOther, kOther), 0);
  EXPECT_THAT(ring().notes(), ElementsAre(HasSubstr("read from")));
}

// A scene's author chooses the files that a server reads. The author must not choose where the
// server writes.
TEST_F(PartsCache, NothingIsWrittenBesideAMeshOutsideOfTheScenesFolder) {
  fs::create_directory(folder / "other");
  fs::rename(scenes() / "ring.obj", folder / "other" / "ring.obj");
  EXPECT_THAT(ring_of("../other/ring.obj").notes(),
              Contains(HasSubstr("kept in " + user_cache().string())));
  fs::create_symlink(folder / "other" / "ring.obj", scenes() / "link.obj");
  EXPECT_THAT(ring_of("link.obj").notes(),
              Contains(HasSubstr("read from " + user_cache().string())));
  EXPECT_THAT(kept_in(folder / "other"), IsEmpty());
  EXPECT_THAT(kept_in(scenes()), IsEmpty());
}

// Several threads load one mesh at once. Each must get the parts, and the file must be complete.
TEST_F(PartsCache, ManyLoadsAtOnceLeaveOneWholeFile) {
  const fs::path file = write_scene(R"({ "name": "b", "mass": 1 })",
                                    mesh_text("o", "ring.obj", "", R"(, "body": "b")"));
  std::vector<std::thread> threads;
  std::vector<std::vector<std::string>> notes(4);
  for (auto& own : notes) threads.emplace_back([&] { own = load_scene(file).notes(); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& own : notes) EXPECT_THAT(own, ElementsAre(HasSubstr("convex parts")));
  EXPECT_THAT(load_scene(file).notes(), ElementsAre(HasSubstr("read from")));
  // scene, mesh and parts, but no partly written file
  EXPECT_EQ(test::files_in(scenes()).size(), 3u);
}

TEST_F(PartsCache, ALoadIsCancelledWhileItCuts) {
  write("ring.obj", test::torus(0.05, 0.005, 400, 100));
  const fs::path file =
      write_scene(R"({ "name": "b", "mass": 1 })",
                  mesh_text("o", "ring.obj", R"(, "convex_parts": { "tolerance": 0.0002 })",
                            R"(, "body": "b")"));
  CancellableWork work;
  bool cancelled = false;
  std::thread loading([&] {
    const WorkScope doing(&work);
    try {
      load_scene(file);
    } catch (const Cancelled&) {
      cancelled = true;
    }
  });
  while (!work.progress().starts_with("objects[0].mesh.convex_parts")) std::this_thread::yield();
  work.cancel();
  loading.join();
  EXPECT_TRUE(cancelled);
  EXPECT_THAT(kept_in(scenes()), IsEmpty());
}

TEST_F(PartsCache, WrongFieldsAreNamedWithTheRemedy) {
  EXPECT_THAT(wrong(R"({ "most": 0 })"),
              AllOf(HasSubstr("s.json:4: objects[0].mesh.convex_parts.most: must be 1 to 1024"),
                    HasSubstr("give 1 for the convex hull of the whole")));
  EXPECT_THAT(wrong(R"({ "most": 1025 })"), HasSubstr("is 1025"));
  EXPECT_NE(wrong(R"({ "most": -1 })"), "no error");
  EXPECT_THAT(wrong(R"({ "tolerance": 0 })"),
              HasSubstr("convex_parts.tolerance: must be above zero [m]"));
  EXPECT_THAT(
      wrong(R"({ "tolerance": 0.0001 })"),
      HasSubstr("convex_parts.tolerance: must be at least 0.001 of the mesh's longest side"));
  EXPECT_THAT(wrong(R"({ "tolerence": 0.001 })"), HasSubstr("the fields are: tolerance, most"));
  EXPECT_EQ(wrong("{}"), "no error");
  // The check must also run if nothing moves.
  EXPECT_THAT(error_of("", mesh_text("o", "ring.obj", R"(, "convex_parts": { "most": 0 })")),
              HasSubstr("convex_parts.most"));
  EXPECT_THAT(error_of("", mesh_text("o", "ring.obj") + ", " +
                               mesh_text("p", "ring.obj", R"(, "convex_parts": { "most": 0 })")),
              HasSubstr("objects[1].mesh.convex_parts.most"));
}

TEST_F(PartsCache, ATooSmallNumberOfPartsIsWarnedOf) {
  const Scene s = ring(R"(, "convex_parts": { "most": 3 })");
  EXPECT_THAT(s.warnings(), Contains(AllOf(HasSubstr("object 'o': the 3 convex parts"),
                                           HasSubstr("more than convex_parts.tolerance, 2.53 mm"),
                                           HasSubstr("more parts with convex_parts.most"))));
  EXPECT_THAT(ring().warnings(), Not(Contains(HasSubstr("convex"))));
}

}  // namespace
}  // namespace feltwire::parts_cache_test
