// Tests the server while scenes load slowly or never finish.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>
#include <future>

#include "core/base/cancellation.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/app/health.hpp"
#include "server/app/server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/reload.hpp"
#include "tests/support/program.hpp"

namespace feltwire::loading_test {
namespace {

using control::RefusalCode;
using control::Refused;
using test::ControlClient;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::chrono::milliseconds kWait{test::kPatience};

std::string json(const std::string& name, double stiffness = 500) {
  return R"({"name": ")" + name + R"(", "materials": [{"name": "m", "stiffness": )" +
         std::to_string(stiffness) + R"(}],
"objects": [{"name": "floor", "plane": {}, "material": "m"}]})";
}

/// Blocks loads of a file until the test releases them.
class Hold {
 public:
  explicit Hold(std::string file, bool looks_at_cancel = true)
      : file_(std::move(file)), looks_(looks_at_cancel) {}

  SceneLoader::Load load() {
    return [this](const std::filesystem::path& file) {
      if (file == file_) {
        ++begun_;
        begun_.notify_all();
        while (held_) {
          if (looks_) check_cancelled();
          std::this_thread::yield();
        }
        ++ended_;
        ended_.notify_all();
      }
      return load_scene(file);
    };
  }
  void wait_until_begun() {
    for (int n = begun_; n == 0; n = begun_) begun_.wait(n);
  }
  void let_go() { held_ = false; }
  void wait_until_ended() {
    for (int n = ended_; n == 0; n = ended_) ended_.wait(n);
  }

 private:
  const std::string file_;
  const bool looks_;
  std::atomic<bool> held_{true};
  std::atomic<int> begun_{0}, ended_{0};
};

/// A server of two scenes. Loads of "slow" are blocked, and "quick" loads at once. The tokens are
/// in a file.
struct TwoScenes {
  explicit TwoScenes(bool looks_at_cancel = true) : hold(slow, looks_at_cancel) {
    std::ofstream(slow) << json("slow");
    std::ofstream(quick) << json("quick");
    change_tokens(tokens, [&](Tokens& all) {
      all.push_back(test::admin_token().token);
      all.push_back(looker.token);
      all.push_back(guest.token);
    });
    ServerConfig config = test::any_port();
    config.scenes = {slow, quick};
    std::vector<Scene> scenes;
    for (const auto& file : config.scenes) scenes.push_back(load_scene(file));
    server.emplace(config, std::move(scenes), Security{test::identity(), {}, TokenFile(tokens)},
                   hold.load());
  }

  const testing::TemporaryFolder folder;
  const std::string slow = folder / "slow.json", quick = folder / "quick.json",
                    tokens = folder / "tokens.json";
  const IssuedToken guest = issue_token("guest", "*", Role::operator_, std::nullopt),
                    looker = issue_token("looker", "*", Role::admin, std::nullopt);
  Hold hold;
  std::optional<Server> server;
};

control::JoinRequest join_to(const std::string& scene) {
  control::JoinRequest request = test::join_request();
  request.scene = scene;
  return request;
}

TEST(Loading, HoldsUpNeitherJoinsNorHealthNorRevocationNorOtherReloads) {
  TwoScenes two;
  const std::uint16_t port = two.server->control_port();
  ControlClient guest(port, AF_INET, two.guest.text);
  guest.join(join_to("quick"));
  guest.join(join_to("slow"));
  ControlClient reloading(port);
  reloading.send(control::ReloadScene{"slow"});
  two.hold.wait_until_begun();

  ControlClient admin(port);
  admin.join(join_to("quick"));
  admin.join(join_to("slow"));
  EXPECT_NO_THROW(check_health("127.0.0.1", port, kWait));
  EXPECT_EQ(admin.ask<control::SceneReloaded>(control::ReloadScene{"quick"}).scene, "quick");
  const auto again = admin.ask<Refused>(control::ReloadScene{"slow"});
  EXPECT_EQ(again.code, RefusalCode::too_many);
  EXPECT_THAT(again.reason, HasSubstr("is being loaded already"));

  // an admin with a limited number of requests
  ControlClient looker(port, AF_INET, two.looker.text);
  std::size_t seen = 0;
  const auto sessions = [&] {
    looker.send(control::ListSessions{});
    const auto answer = looker.receive();
    if (const auto* list = answer ? std::get_if<control::SessionList>(&*answer) : nullptr)
      seen = list->sessions.size();
    return seen;
  };
  EXPECT_EQ(sessions(), 4u);
  change_tokens(two.tokens, [](Tokens& all) { all.pop_back(); });
  const auto end = std::chrono::steady_clock::now() + kWait;
  while (sessions() > 2 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_EQ(sessions(), 2u);
  EXPECT_EQ(guest.ask<Refused>(control::ListScenes{}).code, RefusalCode::unauthenticated);

  two.hold.let_go();
  const auto answer = reloading.receive();
  ASSERT_TRUE(answer && std::holds_alternative<control::SceneReloaded>(*answer));
  EXPECT_EQ(admin.ask<control::SceneReloaded>(control::ReloadScene{"slow"}).scene, "slow");
}

/// The answer takes longer than the idle time of a connection.
TEST(Loading, KeepsTheConnectionOfWhoeverAskedForIt) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "slow.json";
  std::ofstream(file) << json("slow");
  ServerConfig config = test::any_port();
  config.scenes = {file};
  config.connections.idle_timeout = 0.1;
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(file));
  Hold hold(file);
  Server server(config, std::move(scenes), test::security(), hold.load());
  ControlClient reloading(server.control_port());
  reloading.send(control::ReloadScene{"slow"});
  hold.wait_until_begun();
  // The server meanwhile closes idle connections after the idle time.
  for (int n = 0; n < 3; ++n) {
    ControlClient idle(server.control_port());
    EXPECT_TRUE(idle.closed());
  }
  hold.let_go();
  const auto answer = reloading.receive();
  EXPECT_TRUE(answer && std::holds_alternative<control::SceneReloaded>(*answer));
  EXPECT_TRUE(reloading.closed());  // The connection is now idle.
}

TEST(Loading, IsCancelledWhenTheServerStops) {
  TwoScenes two;
  two.server->reload();
  two.hold.wait_until_begun();
  EXPECT_TRUE(two.server->stop());
}

/// A read from a dead disk cannot be cancelled. The read may return after the server's end.
TEST(Loading, ThatNeverEndsIsLeftBehindWhenTheServerStops) {
  TwoScenes two(false);
  bool told = false;
  two.server->reload([&](const auto&) { told = true; });
  two.hold.wait_until_begun();
  EXPECT_FALSE(two.server->stop());
  two.server.reset();
  two.hold.let_go();
  two.hold.wait_until_ended();
  EXPECT_FALSE(told);
}

/// Writes a scene of 50 fine grids of a mesh. Loading this scene takes minutes.
void write_slow_scene(const testing::TemporaryFolder& folder, const std::string& file) {
  std::ofstream(folder / "cube.obj")
      << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
         "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  std::ofstream out(file);
  out << R"({"name": "room", "materials": [{"name": "m", "stiffness": 500}], "objects": [)";
  for (int n = 0; n < 50; ++n)
    out << (n > 0 ? "," : "") << R"({"name": "g)" << n << R"(", "material": "m",
 "grid": {"file": "cube.obj", "scale": 0.2, "resolution": 0.001, "band": 0.02}})";
  out << "]}";
}

TEST(Loading, OfTheProgramEndsAtSigterm) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  std::ofstream(file) << json("room");
  test::Program program(FELTWIRE_SERVER_PROGRAM,
                        {"--scene", file, "--port", "0", "--state", folder / "state"});
  EXPECT_THAT(program.line(), StartsWith("fingerprint: "));
  EXPECT_THAT(program.line(), StartsWith("listening: "));
  write_slow_scene(folder, file);
  program.signal(SIGHUP);
  EXPECT_THAT(program.error_until("room.json: loading"), HasSubstr("loading"));
  program.signal(SIGTERM);
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.error, ::testing::Not(HasSubstr("was reloaded")));
}

TEST(Loading, OfTheProgramEndsAtSigtermBeforeItServes) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  write_slow_scene(folder, file);
  test::Program program(FELTWIRE_SERVER_PROGRAM, {"--scene", file, "--port", "0", "--state",
                                                  folder / "state", "--log-level", "info"});
  EXPECT_THAT(program.error_until("loading"), HasSubstr("loading"));
  program.signal(SIGTERM);
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.error, HasSubstr("before it served"));
}

TEST(Loading, OfTheProgramRefusesWhatIsNoFile) {
  const testing::TemporaryFolder folder;
  const std::string fifo = folder / "room.json";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  test::Program program(FELTWIRE_SERVER_PROGRAM,
                        {"--scene", fifo, "--port", "0", "--state", folder / "state"});
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error, HasSubstr("room.json: is a pipe; name a regular file"));
}

}  // namespace
}  // namespace feltwire::loading_test
