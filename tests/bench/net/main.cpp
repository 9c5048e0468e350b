#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <cstdio>
#include <cstdlib>

#include "tests/bench/net/load.hpp"
using namespace feltwire;
using namespace feltwire::netbench;
int main(int argc, char** argv) {
  for (int n : {250, 10, 1})
    for (int r = 0; r < atoi(argv[2]); ++r)
      for (auto kind : {HostKind::echo_blocking, HostKind::echo_waiting, HostKind::echo_spinning,
                        HostKind::ours_sleeping, HostKind::ours_spinning, HostKind::ours_bounded}) {
        for (bool sat : {true, false}) {
          if (argc > 3 && (!sat || int(kind) != atoi(argv[3]))) continue;
          if (n != 250 && sat) continue;
          HostOptions o;
          o.kind = kind;
          o.scene_file = argv[1];
          o.clients = n;
          o.cores = {0};
          HostProcess h(o);
          pin_to(1);
          LoadOptions lo;
          lo.saturate = sat;
          if (argc > 4) lo.duration = std::chrono::seconds(atoi(argv[4]));
          Load l(h.targets()[0], !ours(kind), lo);
          auto x = l.run(h.process());
          std::printf(
              "%d %-24s %s cpu/answer %.0f ns busy %.3f late %.4f%% answered %lu bad %lu force "
              "%.3f p50 %.1f p99 %.1f p999 %.1f us pause %.1f us size %zu %zu\n",
              n, name(kind), sat ? "sat" : "paced", x.cpu_per_answer(), x.server_busy(),
              100 * x.late_share(), x.answered, x.bad, double(x.with_force) / x.answered,
              x.round_trip.quantile(.5) * 1e-3, x.round_trip.quantile(.99) * 1e-3,
              x.round_trip.quantile(.999) * 1e-3, x.longest_pause.count() * 1e-3, x.sample_size,
              x.answer_size);
        }
      }
}
