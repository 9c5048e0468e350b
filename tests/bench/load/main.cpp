// feltwire-load drives many hands of a server from one thread, and prints one JSON object a second.
// Start several of it to use more cores. tests/bench/hands_a_core.py measures with it.

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>

#include "core/build_info/build_info.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/session/profiles.hpp"
#include "tests/bench/load/hands.hpp"

namespace feltwire::load {
namespace {

volatile std::sig_atomic_t stopped = 0;

/// Each hand has a port of its own.
void allow_many_ports() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
}

void print(const Hands& hands, const Counts& counts, double time) {
  std::printf(
      "{\"hands\": %zu, \"seconds\": %.3f, \"datagrams\": %llu, \"replies\": %llu, \"with_force\": "
      "%llu, \"p50_us\": %.1f, \"p99_us\": %.1f, \"max_us\": %.1f, \"silent\": %zu, \"ended\": "
      "%zu, "
      "\"skipped\": %llu}\n",
      hands.count(), time, static_cast<unsigned long long>(counts.datagrams),
      static_cast<unsigned long long>(counts.replies),
      static_cast<unsigned long long>(counts.with_force), 1e-3 * counts.round_trip.quantile(0.5),
      1e-3 * counts.round_trip.quantile(0.99), 1e-3 * static_cast<double>(counts.round_trip.max()),
      hands.silent(now()), hands.ended(), static_cast<unsigned long long>(counts.skipped));
  std::fflush(stdout);
}

void drive(const Options& options, int wanted, double duration) {
  constexpr Nanoseconds kSecond = std::chrono::seconds(1);
  constexpr Nanoseconds kBetweenJoins = std::chrono::milliseconds(2);
  Hands hands(options);
  const Nanoseconds begin = now();
  Nanoseconds next = begin + kSecond;
  while (stopped == 0 && now() - begin < from_seconds(duration)) {
    if (hands.count() < static_cast<std::size_t>(wanted)) {
      hands.join_one();
      hands.run_until(now() + kBetweenJoins);
    } else {
      hands.run_until(next);
    }
    if (now() < next) continue;
    const Counts counts = hands.take_counts();
    const Nanoseconds time = now() - (next - kSecond);
    print(hands, counts, seconds(time));
    next += time;
  }
}

int start(int argc, char** argv) {
  Options options;
  std::string server, profile = "wan";
  int hands = 100;
  double duration = 10.0, rate = 1000.0;
  CLI::App app(
      "Many hands of one server, as real sessions without a servo (docs/lab/hands_a_core.md).",
      "feltwire-load");
  app.set_version_flag("--version", [] { return build_info("feltwire-load"); });
  app.add_option(
         "--connect", server,
         "HOST:PORT of the server. Credentials: FELTWIRE_FINGERPRINT_FILE and FELTWIRE_TOKEN_FILE")
      ->required();
  app.add_option("--scene", options.scene, "Name of the scene")->required();
  app.add_option("--hands", hands, "Number of hands")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--profile", profile, "Network that they ask for, " + network_profile_names())
      ->capture_default_str();
  app.add_option("--rate", rate, "[Hz] Rate of a hand's servo")
      ->check(CLI::Range(60.0, 10e3))
      ->capture_default_str();
  app.add_option("--seconds", duration, "[s] Time of the run, with the joins")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--depth", options.depth, "[m] Depth to which the hands press")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of the hands' phases")->capture_default_str();
  if (const auto status = ends_at_arguments(app, argc, argv)) return *status;
  options.server = access_from_environment(server);
  options.parameters.servo_period = 1.0 / rate;
  options.parameters = over(network_profile(profile), options.parameters);
  allow_many_ports();
  std::signal(SIGINT, [](int) { stopped = 1; });
  std::signal(SIGTERM, [](int) { stopped = 1; });
  drive(options, hands, duration);
  return 0;
}

}  // namespace
}  // namespace feltwire::load

int main(int argc, char** argv) {
  try {
    return feltwire::load::start(argc, argv);
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "feltwire-load: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-load: %s\n", error.what());
    return 1;
  }
}
