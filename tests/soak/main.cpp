// feltwire-soak runs a server under clients that join, leave, change address and die at random. The
// exit status shows whether every check passed.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "core/build_info/build_info.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "server/app/server.hpp"
#include "tests/soak/soak.hpp"

namespace feltwire::soak {
namespace {

void print(const Outcome& outcome) {
  const Account& c = outcome.clients;
  std::printf(
      "%llu lives, %llu ticks at %.0f Hz, %llu replies, %.0f %% with a force, round trip p50 %.0f "
      "us p99 %.0f us\n",
      static_cast<unsigned long long>(c.lives), static_cast<unsigned long long>(c.ticks),
      outcome.rate, static_cast<unsigned long long>(c.replies),
      100.0 * static_cast<double>(c.with_force) /
          static_cast<double>(std::max<std::uint64_t>(c.replies, 1)),
      1e-3 * c.round_trip.quantile(0.5), 1e-3 * c.round_trip.quantile(0.99));
  std::printf("%s", text({outcome.server}).c_str());
  if (!c.last_refusal.empty()) std::printf("refused: %s\n", c.last_refusal.c_str());
  for (const Check& check : outcome.checks)
    std::printf("  %-72s %-28s %s\n", check.what.c_str(), check.measured.c_str(),
                check.holds ? "holds" : "BROKEN");
}

int start(int argc, char** argv) {
  Options options;
  options.scene_file = FELTWIRE_SOURCE_DIR "/scenes/room.json";
  CLI::App app("A server under clients that come and go at random (docs/testing.md).",
               "feltwire-soak");
  app.set_version_flag("--version", [] { return build_info("feltwire-soak"); });
  app.add_option("--seconds", options.seconds, "[s] that they do")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--clients", options.clients, "At once")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  app.add_option("--rate", options.rate, "[Hz] of each client's servo; slower where the machine is")
      ->check(CLI::Range(10.0, 10e3))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Of what happens when")->capture_default_str();
  app.add_option("--scene", options.scene_file, "Scene file")->capture_default_str();
  if (const auto status = ends_at_arguments(app, argc, argv)) return *status;
  const Outcome outcome = soak::run(options);
  print(outcome);
  return outcome.holds() ? 0 : 1;
}

/// glibc counts a thread's cache as memory in use, up to 0.2 MiB a thread, which would hide leaks.
/// The caches can be disabled only before a program starts, so this program restarts itself.
void start_without_thread_caches(char** argv) {
  constexpr const char* kName = "GLIBC_TUNABLES";
  if (std::getenv(kName) != nullptr) return;
  ::setenv(kName, "glibc.malloc.tcache_count=0", 0);
  // This call returns only on failure. The caches then count as memory in use.
  ::execv("/proc/self/exe", argv);
}

}  // namespace
}  // namespace feltwire::soak

int main(int argc, char** argv) {
  feltwire::soak::start_without_thread_caches(argv);
  try {
    return feltwire::soak::start(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-soak: %s\n", error.what());
    return 1;
  }
}
