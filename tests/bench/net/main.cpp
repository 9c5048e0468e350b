// feltwire-netbench compares our server under load with bare echoes. The server uses one core and
// the load another. The program prints tables and bars. Its exit status does not depend on the
// results.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>

#include "core/build_info/build_info.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "tests/bench/net/measures.hpp"

namespace feltwire::netbench {
namespace {

void print_header(const Settings& settings) {
  std::printf(
      "scene %s, redundancy %d, %s, %d rounds of %g s, medians; server on core %d, load on core "
      "%d\n",
      settings.scene.c_str(), settings.redundancy,
      settings.suite == CipherSuite::aes_256_gcm ? "AES-256-GCM" : "ChaCha20-Poly1305",
      settings.rounds, settings.seconds, kServerCore, kLoadCore);
}

void print_bar(const char* what, double value, const char* relation, double bar) {
  const bool holds = relation[0] == '<' ? value <= bar : value >= bar;
  std::printf("  %-66s %8.2f %s %6.2f  %s\n", what, value, relation, bar,
              holds ? "holds" : "MISSED");
}

void print_sweep(const Sweep& sweep) {
  const Figures& any = sweep.at(kSaturation).at(HostKind::ours_sleeping);
  const Figures& paced = sweep.at(kSaturatingClients).at(HostKind::ours_sleeping);
  std::printf("\nsample %zu bytes, answer %zu bytes; %.0f %% of our answers carry a force\n",
              any.sample_size, any.answer_size, 100.0 * paced.with_force);
  std::printf("\n%-9s %-24s %12s %8s %9s %9s %9s %9s\n", "clients", "server", "CPU/answer", "core",
              "p50", "p99", "p99.9", "late");
  std::printf("%-9s %-24s %12s %8s %9s %9s %9s %9s\n", "", "", "ns", "%", "us", "us", "us", "%");
  for (const auto& [clients, kinds] : sweep)
    for (const HostKind kind : kKinds) {
      const Figures& f = kinds.at(kind);
      const std::string who = clients == kSaturation ? "saturated" : std::to_string(clients);
      std::printf("%-9s %-24s %12.0f %8.1f %9.1f %9.1f %9.1f %9.3f\n", who.c_str(), name(kind),
                  f.cpu, 100.0 * f.busy, f.p50, f.p99, f.p999, 100.0 * f.late);
    }

  const auto& full = sweep.at(kSaturation);
  const auto& one = sweep.at(1);
  std::printf("\n");
  // The limit is 3.5 us for an echo of 2.05 us. It is scaled by the cost of an echo on this
  // machine.
  constexpr double kBar = 3.5, kBarsEcho = 2.05;
  const double echo = 1e-3 * full.at(HostKind::echo_blocking).cpu;
  print_bar("CPU per sealed answer, saturated [us], at most 3.5 / 2.05 blocking echoes",
            1e-3 * full.at(HostKind::ours_sleeping).cpu, "<=", kBar / kBarsEcho * echo);
  print_bar(
      "CPU per answer, 250 clients to 10",
      sweep.at(250).at(HostKind::ours_sleeping).cpu / sweep.at(10).at(HostKind::ours_sleeping).cpu,
      "<=", 1.0);
  print_bar("round trip of one client, p50, sleeping, to the blocking echo's",
            one.at(HostKind::ours_sleeping).p50 / one.at(HostKind::echo_blocking).p50, "<=", 1.3);
  print_bar("round trip of one client, p50, spinning, to the spinning echo's",
            one.at(HostKind::ours_spinning).p50 / one.at(HostKind::echo_spinning).p50, "<=", 1.3);
  print_bar("round trip of one client, p99.9, sleeping [ms]",
            1e-3 * one.at(HostKind::ours_sleeping).p999, "<=", 1.0);
  print_bar("round trip of one client, p99.9, spinning [ms]",
            1e-3 * one.at(HostKind::ours_spinning).p999, "<=", 1.0);
}

void print_held(const std::map<HostKind, ClientsHeld>& held) {
  std::printf(
      "\nclients of 1 kHz held, under 0.1 %% of the answers later than 1 ms (steps of %d)\n",
      kClientStep);
  std::printf("%-24s %12s %16s\n", "", "altogether", "between stalls");
  for (const HostKind kind : kHoldingKinds)
    std::printf("%-24s %12d %16d\n", name(kind), held.at(kind).altogether,
                held.at(kind).between_stalls);
  std::printf("\n");
  constexpr double kBar = 220.0, kShareOfEcho = 0.6;  // for sealed datagrams
  const ClientsHeld& ours = held.at(HostKind::ours_sleeping);
  const ClientsHeld& echo = held.at(HostKind::echo_blocking);
  print_bar("clients held, sleeping", ours.altogether, ">=", kBar);
  print_bar("clients held, sleeping, between stalls", ours.between_stalls, ">=", kBar);
  if (echo.altogether > 0)
    print_bar("clients held, sleeping, to the blocking echo's",
              static_cast<double>(ours.altogether) / echo.altogether, ">=", kShareOfEcho);
  if (echo.between_stalls > 0)
    print_bar("clients held, sleeping, to the blocking echo's, between stalls",
              static_cast<double>(ours.between_stalls) / echo.between_stalls, ">=", kShareOfEcho);
}

void print_scaling(const std::vector<Scaling>& scaling) {
  const double one = scaling.front().answers;
  std::printf("\n%-38s %16s %12s\n", "a scene and its own load on each core", "million answers/s",
              "to one core");
  for (const Scaling& s : scaling)
    std::printf("%-38d %17.3f %12.2f\n", s.cores, s.answers, s.answers / one);
  std::printf("\n");
  for (const Scaling& s : scaling)
    if (s.cores == 2) print_bar("two scenes on two cores, to one", s.answers / one, ">=", 1.8);
}

void print_servo(const std::vector<ServoFigures>& servo) {
  std::printf("\n%-38s %9s %9s %12s %12s %12s\n", "our client's servo, 1 kHz", "late p50",
              "late p99", "trip p50", "trip p99", "trip p99.9");
  std::printf("%-38s %9s %9s %12s %12s %12s\n", "", "us", "us", "us", "us", "us");
  for (const ServoFigures& f : servo)
    std::printf("%-38s %9.1f %9.1f %12.1f %12.1f %12.1f\n", f.how.c_str(), f.late_p50, f.late_p99,
                f.round_trip_p50, f.round_trip_p99, f.round_trip_p999);
  std::printf("\n");
  const ServoFigures& ours = servo.at(kServoOurs);
  print_bar("servo late, p50 [us], timer slack 1 ns", ours.late_p50, "<=", 15.0);
  print_bar("servo late, p99 [us], timer slack 1 ns", ours.late_p99, "<=", 100.0);
  print_bar("round trip of our client, p99.9, both real-time [ms]",
            1e-3 * servo.at(kServoRealTime).round_trip_p999, "<=", 1.0);
}

void print_flood(const FloodFigures& figures) {
  std::printf("\n%d clients of 1 kHz beside a flood of garbage\n", kFloodedClients);
  std::printf("%-12s %12s %8s %9s %9s %9s %12s\n", "", "garbage/s", "core %", "p50 us", "p99 us",
              "lost %", "left behind");
  const auto line = [](const char* what, const Flooded& f) {
    std::printf("%-12s %12.0f %8.1f %9.1f %9.1f %9.3f %12d\n", what, f.garbage, 100.0 * f.busy,
                f.p50, f.p99, 100.0 * f.lost, f.left_behind);
  };
  line("alone", figures.alone);
  line("flooded", figures.beside_flood);
  std::printf("\n");
  print_bar("round trip beside the flood, p99 [ms]", 1e-3 * figures.beside_flood.p99, "<=", 2.0);
  print_bar("clients left behind", figures.beside_flood.left_behind, "<=", 0.0);
}

void print_viewing(const ViewingFigures& figures) {
  std::printf(
      "\n%d hands of 1 kHz, alone and beside %d viewers of the live page (page on core %d)\n",
      kWatchedHands, kViewers, page_core());
  std::printf("%-16s %9s %9s %9s %9s %12s\n", "", "p50 us", "p99 us", "p99.9 us", "late %",
              "pictures/s");
  const auto line = [](const char* what, const Watched& w) {
    std::printf("%-16s %9.1f %9.1f %9.1f %9.3f %12.1f\n", what, w.p50, w.p99, w.p999,
                100.0 * w.late, w.pictures);
  };
  line("alone", figures.alone);
  line("beside viewers", figures.beside_viewers);
  std::printf("\n");
  print_bar("round trip beside viewers, p99, to unobserved", figures.p99_ratio, "<=", 1.1);
}

void print_recording(const RecordingFigures& f, const std::string& file, double seconds) {
  std::printf("\n%d hands of 1 kHz for %g s, without and with a recording (recorder on core %d)\n",
              kRecordedHands, seconds, page_core());
  std::printf("%-18s %10s %9s %12s %12s\n", "", "core %", "late %", "answers/s", "kB/s");
  std::printf("%-18s %10.2f %9.3f\n", "without", 100.0 * f.alone, 100.0 * f.late_alone);
  std::printf("%-18s %10.2f %9.3f %12.0f %12.0f\n\n", "with", 100.0 * f.recording,
              100.0 * f.late_recording, f.answers, 1e-3 * f.bytes);
  print_bar("cost of the recording [% of a core]", 100.0 * f.cost, "<=", 5.0);
  print_bar("events lost", static_cast<double>(f.lost), "<=", 0.0);
  std::printf("recorded: %s; feltwire-lab replay %s computes it again\n", file.c_str(),
              file.c_str());
}

int run(int argc, char** argv) {
  Settings settings;
  settings.scene = FELTWIRE_SOURCE_DIR "/scenes/room.json";
  std::vector<std::string> only;
  CLI::App app("The server under load, beside bare echoes (docs/lab/benchmarks.md).",
               "feltwire-netbench");
  app.set_version_flag("--version", [] { return build_info("feltwire-netbench"); });
  app.add_option("--scene", settings.scene, "Scene file")->capture_default_str();
  app.add_option("--rounds", settings.rounds, "Runs of everything, in turns")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--seconds", settings.seconds, "[s] of a run")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option("--redundancy", settings.redundancy, "Earlier samples in each datagram")
      ->check(CLI::Range(0, kMaxRedundancy))
      ->capture_default_str();
  app.add_option("--suite", settings.suite,
                 "aes_256_gcm or chacha20_poly1305; the faster one when not given")
      ->transform(CLI::CheckedTransformer(std::map<std::string, CipherSuite>{
          {"aes_256_gcm", CipherSuite::aes_256_gcm},
          {"chacha20_poly1305", CipherSuite::chacha20_poly1305}}));
  app.add_option("--only", only,
                 "sweep, held, scenes, flood, servo, viewing, recording; all when not given")
      ->check(CLI::IsMember({"sweep", "held", "scenes", "flood", "servo", "viewing", "recording"}));
  std::string record;
  app.add_option("--record", record,
                 "FILE.mcap that the server records in `recording`. When not given: that is left "
                 "out");
  if (const auto status = ends_at_arguments(app, argc, argv)) return *status;
  if (cores() < 2) throw std::runtime_error("two cores are needed: server and load have one each");

  if (record.empty() && std::find(only.begin(), only.end(), "recording") != only.end())
    throw std::runtime_error("--only recording: it needs a file; give --record FILE.mcap");
  const auto wanted = [&](const char* what) {
    return only.empty() || std::find(only.begin(), only.end(), what) != only.end();
  };
  print_header(settings);
  if (wanted("sweep")) print_sweep(sweep(settings));
  if (wanted("held")) print_held(clients_held(settings));
  if (wanted("scenes")) print_scaling(scaling(settings));
  if (wanted("flood")) print_flood(flood(settings));
  if (wanted("viewing")) print_viewing(viewing(settings));
  if (wanted("recording") && !record.empty())
    print_recording(recording(settings, record), record, settings.seconds);
  if (wanted("servo")) print_servo(servo(settings));
  return 0;
}

}  // namespace
}  // namespace feltwire::netbench

int main(int argc, char** argv) {
  try {
    return feltwire::netbench::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-netbench: %s\n", error.what());
    return 1;
  }
}
