// A bad file may crash MuJoCo's loader. Only the process that reads the file may fail.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "core/base/cancellation.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene_file/load_scene.hpp"

namespace feltwire::mujoco_load_test {
namespace {

using mujoco::load_text;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kGood = "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>";
// The product of rows and columns overflows. MuJoCo 2.2 then fails while it holds the lock of its
// loader.
const std::string kNoMemory =
    "<mujoco><asset><hfield name='h' nrow='65535' ncol='65535' size='1 1 1 1'/></asset></mujoco>";
// MuJoCo 2.2 reads beyond the vertices of this mesh.
const std::string kCrash =
    "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' "
    "face='0 1 99999999 1 2 3 0 2 3 0 1 3'/></asset>"
    "<worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>";

std::size_t descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

TEST(MujocoLoad, AfterAnErrorTheNextFileIsRead) {
  for (int n = 0; n < 3; ++n) {
    const std::string wrong = load_text(kNoMemory).error;
    EXPECT_NE(wrong, "");
#ifndef FELTWIRE_SANITIZED  // Sanitizers end the program before MuJoCo reports the reason.
    EXPECT_THAT(wrong, HasSubstr("Could not allocate memory"));
#endif
    const mujoco::Loaded good = load_text(kGood);
    ASSERT_NE(good.model, nullptr) << good.error;
    EXPECT_EQ(good.model->ngeom, 1);
  }
}

TEST(MujocoLoad, AFileThatCrashesTheLoaderIsAnError) {
  const mujoco::Loaded crashed = load_text(kCrash);
  EXPECT_EQ(crashed.model, nullptr);
#ifndef FELTWIRE_SANITIZED  // Sanitizers handle the signal themselves.
  EXPECT_THAT(crashed.error, HasSubstr("crashed on it (signal 11)"));
#endif
}

TEST(MujocoLoad, NothingIsLeftOfAnyOfThem) {
  load_text(kGood);
  const std::size_t before = descriptors();
  for (int n = 0; n < 5; ++n)
    for (const std::string& text : {kGood, kNoMemory, kCrash, std::string("no XML")})
      load_text(text);
  EXPECT_EQ(descriptors(), before);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(MujocoLoad, ManyThreadsLoadAtOnce) {
  std::vector<std::thread> threads;
  std::vector<std::string> errors(4);
  for (std::string& error : errors)
    threads.emplace_back([&error] {
      for (int n = 0; n < 3; ++n)
        if (load_text(kGood).model == nullptr || load_text(kNoMemory).error.empty())
          error = "wrong";
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(errors, ::testing::Each(std::string()));
}

/// Returns a model that takes minutes to load, with 10000 bodies.
std::string slow_model() {
  std::string text = "<mujoco><size nconmax='16' njmax='48' nstack='200000000'/><worldbody>";
  for (int i = 0; i < 10000; ++i)
    text += "<body name='b" + std::to_string(i) + "' pos='" + std::to_string(i) +
            " 0 0'><freejoint/><geom size='0.1'/></body>";
  return text + "</worldbody></mujoco>";
}

/// Returns the child processes that this process has not yet waited for.
std::vector<pid_t> children() {
  std::vector<pid_t> all;
  for (const auto& process : std::filesystem::directory_iterator("/proc")) {
    std::ifstream status(process.path() / "stat");  // In "12 (name) S 3 ...", 3 is the parent.
    std::string text;
    std::getline(status, text);
    const std::size_t name_ends = text.rfind(')');
    if (name_ends == std::string::npos) continue;
    std::istringstream rest(text.substr(name_ends + 1));
    char state = 0;
    pid_t parent = 0;
    if (rest >> state >> parent && parent == getpid()) all.push_back(std::stoi(text));
  }
  return all;
}

TEST(MujocoLoad, ALoadThatIsCancelledEndsItsProcess) {
  const std::string slow = slow_model();
  for (const bool at_once : {true, false}) {
    CancellableWork work;
    if (at_once) work.cancel();
    std::atomic<bool> cancelled = false, ended = false;
    std::thread loading([&] {
      const WorkScope doing(&work);
      try {
        load_text(slow);
      } catch (const Cancelled&) {
        cancelled = true;
      }
      ended = true;
    });
    while (!at_once && children().empty() && !ended) std::this_thread::yield();
    work.cancel();
    loading.join();
    EXPECT_TRUE(cancelled) << at_once;
    EXPECT_THAT(children(), ::testing::IsEmpty());
    // The load must already have waited for the child.
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
  }
}

TEST(MujocoLoad, ALoadThatIsNotCancelledIsTheSame) {
  CancellableWork work;
  const WorkScope doing(&work);
  const mujoco::Loaded good = load_text(kGood);
  ASSERT_NE(good.model, nullptr) << good.error;
  EXPECT_NE(load_text("no XML").error, "");
}

/// Creates scenes in a folder, and files outside that the scenes name by links.
class ShownErrors : public ::testing::Test {
 protected:
  ShownErrors()
      : root_(std::filesystem::temp_directory_path() /
              ("feltwire_" + std::to_string(std::random_device{}()))) {
    std::filesystem::create_directories(root_ / "scenes");
    std::filesystem::create_directories(root_ / "secret");
    for (const char* name : {"words.obj", "words.pgm", "words.xml", "words.json"})
      write("secret/" + std::string(name), "root:$6$topsecret:1\nnobody:$6$other:2\n");
  }
  ~ShownErrors() override { std::filesystem::remove_all(root_); }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(root_ / name) << text;
  }
  void link(const std::string& name, const std::string& target) {
    std::filesystem::create_symlink(root_ / target, root_ / "scenes" / name);
  }
  std::string error_of(const std::string& file) {
    try {
      load_scene(root_ / "scenes" / file);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  }
  std::string error_of_object(const std::string& shape) {
    write("scenes/s.json",
          R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
              "objects": [{"name": "o", "material": "m", )" +
              shape + "}]}");
    return error_of("s.json");
  }
  std::string error_of_mjcf(const std::string& file) {
    write("scenes/s.json", R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
                               "mjcf": {"file": ")" +
                               file + R"(", "material": "m"}})");
    return error_of("s.json");
  }

  const ::testing::Matcher<std::string> hidden_ =
      AllOf(Not(HasSubstr("topsecret")), Not(HasSubstr("root")),
            HasSubstr("lies outside of the scene's folder"));
  std::filesystem::path root_;
};

TEST_F(ShownErrors, WordsOfAFileOutsideOfTheScenesFolderAreNotShown) {
  link("l.obj", "secret/words.obj");
  link("l.pgm", "secret/words.pgm");
  link("folder", "secret");
  write("scenes/sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const std::string file : {"l.obj", "../secret/words.obj", "folder/words.obj"}) {
    EXPECT_THAT(error_of_object(R"("mesh": {"unit": "m", "file": ")" + file + R"("})"),
                AllOf(hidden_, HasSubstr(".obj:1: ")))
        << file;
    EXPECT_THAT(
        error_of_object(R"("grid": {"scale": 1, "resolution": 0.1, "file": ")" + file + R"("})"),
        hidden_)
        << file;
  }
  EXPECT_THAT(error_of_object(
                  R"("mesh": {"unit": "m", "file": "sheet.obj",
              "height_map": {"file": "l.pgm", "amplitude": 0.001, "size": 1}})"),
              AllOf(hidden_, HasSubstr("l.pgm: byte 0")));
}

TEST_F(ShownErrors, NorThoseOfASceneThatIsItselfALink) {
  link("l.json", "secret/words.json");
  EXPECT_THAT(error_of("l.json"), AllOf(hidden_, HasSubstr("l.json:1: ")));
}

TEST_F(ShownErrors, NorThoseThatMuJoCoQuotesOfAnIncludedFile) {
  const std::string secret = "<mujoco><root_topsecret/></mujoco>";
  write("secret/words.xml", secret);
  link("l.xml", "secret/words.xml");
  EXPECT_THAT(error_of_mjcf("l.xml"), hidden_);
  for (const std::string& model :
       {std::string("<mujoco><include file=\"l.xml\"/></mujoco>"),
        "<mujoco><include file = '" + (root_ / "secret/words.xml").string() + "'/></mujoco>",
        std::string("<mujoco><include file=\"&#108;.xml\"/></mujoco>"),
        std::string("<mujoco><include file=\"inner.mesh\"/></mujoco>"),
        std::string("<mujoco><compiler meshdir='../secret'/><asset><mesh name='m' "
                    "file='words.obj'/></asset></mujoco>")}) {
    write("scenes/inner.mesh", "<mujoco><include file=\"l.xml\"/></mujoco>");
    write("scenes/m.xml", model);
    EXPECT_THAT(error_of_mjcf("m.xml"), hidden_) << model;
  }
}

/// The loader must not wait for a pipe or read an endless file. The test names such files in each
/// kind of element.
TEST_F(ShownErrors, FilesThatAreNoRegularOnesAreRefused) {
  for (const char* name : {"pipe.xml", "pipe.stl", "pipe.png", "pipe.bin"})
    ASSERT_EQ(mkfifo((root_ / "scenes" / name).c_str(), 0600), 0);
  std::filesystem::create_directory(root_ / "scenes" / "folder.stl");
  const auto mjcf = [&](const std::string& inside) {
    write("scenes/m.xml", "<mujoco>" + inside + "<worldbody><geom size='1'/></worldbody></mujoco>");
    return error_of_mjcf("m.xml");
  };
  const std::pair<std::string, std::string> all[] = {
      {"<include file='pipe.xml'/>", "pipe.xml"},
      {"<asset><mesh name='m' file='pipe.stl'/></asset>", "pipe.stl"},
      {"<asset><hfield name='h' file='pipe.png' size='1 1 1 1'/></asset>", "pipe.png"},
      {"<asset><hfield name='h' file='pipe.bin' size='1 1 1 1'/></asset>", "pipe.bin"},
      {"<asset><texture name='t' type='2d' file='pipe.png'/></asset>", "pipe.png"}};
  for (const auto& [inside, file] : all)
    EXPECT_THAT(mjcf(inside), HasSubstr(file + ": is a pipe; name a regular file")) << inside;
  EXPECT_THAT(mjcf("<asset><mesh name='m' file='folder.stl'/></asset>"),
              HasSubstr("folder.stl: is a directory; name a regular file"));
  std::filesystem::create_symlink("/dev/zero", root_ / "scenes" / "zero.xml");
  write("scenes/m.xml", "<mujoco><include file='zero.xml'/></mujoco>");
  EXPECT_THAT(mujoco::load_file((root_ / "scenes/m.xml").string()).error,
              HasSubstr("zero.xml: is a device; name a regular file"));
  EXPECT_THAT(error_of_mjcf("m.xml"), HasSubstr("lies outside of the scene's folder"));
  EXPECT_THAT(error_of_mjcf("pipe.xml"), HasSubstr("is a pipe"));
}

TEST_F(ShownErrors, WordsOfFilesInTheFolderAreShown) {
  write("scenes/torn.obj", "v 0 zz 0\n");
  link("near.obj", "scenes/torn.obj");
  for (const std::string file : {"torn.obj", "near.obj"})
    EXPECT_THAT(error_of_object(R"("mesh": {"unit": "m", "file": ")" + file + R"("})"),
                HasSubstr(file + ":1: v: must be a number, is 'zz'"));
  write("scenes/m.xml", "<mujoco><wordbody/></mujoco>");
  EXPECT_THAT(error_of_mjcf("m.xml"), HasSubstr("wordbody"));
  EXPECT_THAT(error_of_mjcf("none.xml"), HasSubstr("none.xml: cannot be opened"));
}

/// The error must call a missing file of a URI missing, instead of outside the folder.
TEST_F(ShownErrors, AMissingFileOfAPackageIsSaidToBeMissing) {
  for (const std::string uri : {"package://pkg/meshes/none.stl", "file:///proc/nowhere/none.stl"}) {
    write("scenes/r.urdf", "<robot name='r'><link name='l'><collision><geometry><mesh filename='" +
                               uri + "'/></geometry></collision></link></robot>");
    EXPECT_THAT(error_of_mjcf("r.urdf"),
                HasSubstr("it names '" + uri + "', which does not exist; correct the name"));
  }
  // A relative path of the scene file must give an equal error.
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(root_ / "scenes");
  std::string message;
  try {
    load_scene("s.json");
  } catch (const std::exception& error) {
    message = error.what();
  }
  std::filesystem::current_path(before);
  EXPECT_THAT(message, HasSubstr("which does not exist"));
}

constexpr const char* kTriangles =
    "v 0 0 0\nv .03 0 0\nv 0 .03 0\nv 0 0 .03\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// MuJoCo looks for the file without its folder, but its message omits this fact. The loader must
/// explain the fact.
TEST_F(ShownErrors, AFolderThatMuJoCoDropsIsExplained) {
  std::filesystem::create_directories(root_ / "scenes" / "meshes");
  write("scenes/meshes/part.obj", kTriangles);
  const std::string collision =
      "<link name='l'><collision><geometry><mesh filename='meshes/part.obj'/></geometry>"
      "</collision></link></robot>";
  for (const std::string compiler : {"strippath='true'", "meshdir='./'"}) {
    write("scenes/r.urdf",
          "<robot name='r'><mujoco><compiler " + compiler + "/></mujoco>" + collision);
    EXPECT_THAT(error_of_mjcf("r.urdf"),
                AllOf(HasSubstr("part.obj"), HasSubstr("dropped the folder of 'meshes/part.obj'"),
                      HasSubstr("strippath=\"false\"")))
        << compiler;
  }
  write("scenes/m.xml",
        "<mujoco><compiler strippath='true'/><asset><mesh name='p' file='meshes/part.obj'/></asset>"
        "<worldbody><geom type='mesh' mesh='p'/></worldbody></mujoco>");
  EXPECT_THAT(error_of_mjcf("m.xml"), HasSubstr("dropped the folder of 'meshes/part.obj'"));
}

/// MuJoCo uses the hull of an open mesh without a warning. The loader must warn.
TEST_F(ShownErrors, AnOpenMeshOfAModelIsWarnedOf) {
  const auto warnings = [&](const std::string& faces) {
    write("scenes/part.obj", "v 0 0 0\nv .03 0 0\nv 0 .03 0\nv 0 0 .03\n" + faces);
    write("scenes/m.xml",
          "<mujoco><asset><mesh name='p' file='part.obj'/></asset><worldbody>"
          "<geom name='shell' type='mesh' mesh='p'/></worldbody></mujoco>");
    EXPECT_EQ(error_of_mjcf("m.xml"), "no error");
    return load_scene(root_ / "scenes/s.json").warnings();
  };
  EXPECT_THAT(warnings("f 1 3 2\nf 1 2 4\nf 2 3 4\n"),
              Contains(HasSubstr("object 'shell': its mesh is not closed: 3 open edges, 1 hole ")));
  EXPECT_THAT(warnings("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"),
              Not(Contains(HasSubstr("not closed"))));
}

TEST_F(ShownErrors, FeltwiresOwnReasonsAreShownWhateverTheModelNames) {
  std::filesystem::create_directories(root_ / "scenes" / "a");
  write("secret/part.obj", kTriangles);
  write("scenes/a/egg.xml",
        "<mujoco><compiler meshdir='../../secret'/><asset><mesh name='p' file='part.obj'/></asset>"
        "<worldbody><geom name='egg' type='ellipsoid' size='.03 .03 .04'/>"
        "<geom type='mesh' mesh='p'/></worldbody></mujoco>");
  EXPECT_THAT(error_of_mjcf("a/egg.xml"),
              AllOf(HasSubstr("geom 'egg' of body 'world': only plane, sphere"),
                    Not(HasSubstr("not shown"))));
  // The message must not show names from a text outside the folder.
  write("secret/topsecret.xml",
        "<mujoco><worldbody><geom name='topsecret' type='ellipsoid' size='1 1 2'/></worldbody>"
        "</mujoco>");
  write("scenes/m.xml", "<mujoco><include file='../secret/topsecret.xml'/></mujoco>");
  const std::string outside = error_of_mjcf("m.xml");
  EXPECT_THAT(outside,
              AllOf(HasSubstr("a geom of it: only plane, sphere"), Not(HasSubstr("topsecret"))));
  EXPECT_THAT(error_of_mjcf("../secret/topsecret.xml"),
              AllOf(HasSubstr("a geom of it: only plane"), Not(HasSubstr("'topsecret'"))));
}

TEST_F(ShownErrors, AFileThatDoesNotExistIsSaidToBeMissing) {
  for (const char* name : {"none.xml", "../secret/none.xml", "/no/such/none.xml"})
    EXPECT_THAT(error_of_mjcf(name), AllOf(HasSubstr("none.xml: cannot be opened: No such file"),
                                           Not(HasSubstr("not shown"))))
        << name;
  for (const char* name : {"none.stl", "../secret/none.stl", "folder/none.obj"}) {
    write("scenes/m.xml", "<mujoco><asset><mesh name='m' file='" + std::string(name) +
                              "'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody>"
                              "</mujoco>");
    EXPECT_THAT(error_of_mjcf("m.xml"),
                HasSubstr("it names '" + std::string(name) + "', which does not exist"));
  }
  write("scenes/m.xml", "<mujoco><include file='none.xml'/></mujoco>");
  EXPECT_THAT(error_of_mjcf("m.xml"), HasSubstr("it names 'none.xml', which does not exist"));
}

TEST_F(ShownErrors, APointerOfGitLfsIsNamedWhereverItStands) {
  const std::string lfs = "version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 2\n";
  write("scenes/lfs.xml", lfs);
  EXPECT_THAT(error_of_mjcf("lfs.xml"), HasSubstr("git lfs pull"));
  write("scenes/lfs.stl", lfs);
  write("scenes/m.xml",
        "<mujoco><asset><mesh name='m' file='lfs.stl'/></asset><worldbody><geom type='mesh' "
        "mesh='m'/></worldbody></mujoco>");
  EXPECT_THAT(error_of_mjcf("m.xml"),
              AllOf(HasSubstr("lfs.stl is a pointer of Git LFS"), HasSubstr("git lfs pull")));
  write("scenes/json.xml", "{}");
  EXPECT_THAT(error_of_mjcf("json.xml"), HasSubstr("it is no XML"));
  write("scenes/mark.xml",
        "\xEF\xBB\xBF<mujoco><worldbody><geom size='1'/></worldbody></mujoco>\r\n");
  EXPECT_EQ(error_of_mjcf("mark.xml"), "no error");
}

TEST_F(ShownErrors, AXacroTemplateIsToldHowToExpandIt) {
  const std::string urdf =
      "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{}<link name='l'><collision>"
      "<geometry><sphere radius='1'/></geometry></collision></link></robot>";
  const auto told = [&](const std::string& inner) {
    std::string text = urdf;
    text.replace(text.find("{}"), 2, inner);
    write("scenes/r.xml", text);
    return error_of_mjcf("r.xml");
  };
  for (const char* inner : {"<xacro:include filename='a.xacro'/>", "<!-- a -->\n<xacro:arm/>"})
    EXPECT_THAT(told(inner), AllOf(HasSubstr("is a template of Xacro"), HasSubstr("r.xml > ")));
  // The output of Xacro still names its namespace.
  EXPECT_EQ(told(""), "no error");
  EXPECT_EQ(told("<!-- made of <xacro:arm/> -->"), "no error");
}

TEST_F(ShownErrors, AWordOfANewerMuJoCoIsNamedWithTheVersion) {
  const std::string version = std::string("version ") + mj_versionString();
  const auto told = [&](const std::string& inner) {
    write("scenes/m.xml", "<mujoco>" + inner + "</mujoco>");
    return error_of_mjcf("m.xml");
  };
  EXPECT_THAT(told("<size memory='1M'/>"),
              AllOf(HasSubstr(version), HasSubstr("the attribute 'memory' in <size>")));
  EXPECT_THAT(told("<worldbody><flexcomp name='x'/></worldbody>"),
              AllOf(HasSubstr(version), HasSubstr("the element <flexcomp>")));
  EXPECT_THAT(told("<option integrator='implicitfast'/>"),
              AllOf(HasSubstr(version), HasSubstr("the word 'implicitfast' in <option>")));
  EXPECT_THAT(told("<worldbody><geom type='mesh' mesh='none'/></worldbody>"),
              Not(HasSubstr(version)));
}

/// Tests a URDF file with meshes in folders.
TEST_F(ShownErrors, MeshesOfAUrdfFileAreFoundInTheirFolders) {
  std::filesystem::create_directories(root_ / "scenes" / "urdf");
  std::filesystem::create_directories(root_ / "scenes" / "meshes" / "visual");
  std::filesystem::create_directories(root_ / "scenes" / "urdf" / "own");
  // A tetrahedron as binary STL.
  std::string stl(80, 'x');
  const auto put = [&](auto value) {
    stl.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const float corners[4][3] = {{0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, 0, 30}};
  put(std::uint32_t{4});
  for (const auto& face :
       {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{1, 2, 3}, std::array{0, 3, 2}}) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const int corner : face)
      for (const float x : corners[corner]) put(x);
    put(std::uint16_t{0});
  }
  const auto urdf = [](const std::string& name, const std::string& more = "") {
    return "<?xml version='1.0'?><!-- a <robot> --><robot name='r'>" + more +
           "<link name='base'><collision><geometry><mesh filename=\"" + name +
           "\" scale='0.001 0.001 0.001'/></geometry></collision></link></robot>";
  };
  write("scenes/meshes/part.stl", stl);
  write("scenes/urdf/own/part.stl", stl);
  for (const std::string name : {"own/part.stl", "../meshes/part.stl", "package://meshes/part.stl",
                                 "package://some_robot/meshes/part.stl"}) {
    for (const char* more : {"", "<mujoco><compiler discardvisual='true'/></mujoco>",
                             "<mujoco><option gravity='0 0 0'/></mujoco>", "<mujoco/>"}) {
      write("scenes/urdf/r.urdf", urdf(name, more));
      EXPECT_EQ(error_of_mjcf("urdf/r.urdf"), "no error") << name << more;
    }
  }
  // A meshdir in the file's own compiler element must stay valid.
  write("scenes/urdf/r.urdf", urdf("x/y/part.stl", "<mujoco><compiler meshdir='own'/></mujoco>"));
  EXPECT_EQ(error_of_mjcf("urdf/r.urdf"), "no error");
  write("scenes/urdf/r.urdf", urdf("own/none.stl"));
  EXPECT_THAT(error_of_mjcf("urdf/r.urdf"), HasSubstr("own/none.stl"));
  // Recordings must keep the meshes too.
  write("scenes/urdf/r.urdf", urdf("../meshes/part.stl"));
  write("scenes/s.json", R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
                             "mjcf": {"file": "urdf/r.urdf", "material": "m"}})");
  const Scene kept = load_scene_and_keep(root_ / "scenes" / "s.json");
  EXPECT_TRUE(kept.files()->files.contains("meshes/part.stl"));
  EXPECT_EQ(load_kept_scene(*kept.files()).objects().size(), 1u);
}

}  // namespace
}  // namespace feltwire::mujoco_load_test
