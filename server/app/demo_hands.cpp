#include "server/app/demo_hands.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace feltwire {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 2> kHands = {{
    {"left-hand", "simulated:path=figure-eight,radius=0.03,depth=0.005,seed=1"},
    {"right-hand", "simulated:path=taps,depth=0.01,tremor=0.0002,seed=2"},
}};

/// Owns what posix_spawn() needs: the output goes to a file, and no signal is blocked.
struct SpawnSettings {
  explicit SpawnSettings(const std::filesystem::path& log) {
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(),
                                       O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    ::posix_spawnattr_init(&attributes);
    sigset_t none;
    ::sigemptyset(&none);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    // A group of its own: Ctrl-C in the terminal reaches the server alone, which ends the hands.
    ::posix_spawnattr_setpgroup(&attributes, 0);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSettings() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
};

}  // namespace

DemoHands::DemoHands(const DemoHandsSetup& setup) {
  try {
    for (const std::string& scene : setup.scenes)
      for (const auto& [name, device] : kHands) start(setup, scene, name, device);
  } catch (...) {
    end();
    throw;
  }
}

void DemoHands::start(const DemoHandsSetup& setup, const std::string& scene,
                      const std::string& name, const std::string& device) {
  std::vector<std::string> words = {setup.client.string(),
                                    "--connect",
                                    setup.server,
                                    "--fingerprint",
                                    setup.fingerprint,
                                    "--token-file",
                                    setup.token.string(),
                                    "--scene",
                                    scene,
                                    "--name",
                                    name,
                                    "--device",
                                    device,
                                    "--link",
                                    "delay=0",
                                    "--changes",
                                    "any"};
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const SpawnSettings settings(setup.logs / ("demo-" + std::to_string(hands_.size() + 1) + ".log"));
  hands_.reserve(hands_.size() + 1);
  pid_t hand = 0;
  if (const int error = ::posix_spawn(&hand, setup.client.c_str(), &settings.files,
                                      &settings.attributes, arguments.data(), environ))
    throw std::runtime_error("--demo: cannot start " + setup.client.string() + ": " +
                             std::generic_category().message(error));
  hands_.push_back(hand);
}

void DemoHands::end() noexcept {
  for (const pid_t hand : hands_) ::kill(hand, SIGTERM);
  for (const pid_t hand : hands_)
    while (::waitpid(hand, nullptr, 0) < 0 && errno == EINTR) {
    }
  hands_.clear();
}

}  // namespace feltwire
