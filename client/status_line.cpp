#include "client/status_line.hpp"

#include <unistd.h>

#include <cstdio>

namespace feltwire {

StatusLine::StatusLine() : terminal_(::isatty(STDERR_FILENO) == 1) {}

void StatusLine::show(const LiveStatus& status) {
  constexpr double kEvery = 1.0;  // [s] where lines pile up
  if (!terminal_ && shown_ >= 0.0 && status.time - shown_ < kEvery) return;
  const double elapsed = status.time - before_.time;
  const double rate =
      elapsed > 0.0 ? static_cast<double>(status.samples - before_.samples) / elapsed : 0.0;
  const double us = 1e-3;
  std::fprintf(stderr,
               "%s%8.1f s %7.0f Hz   round trip %4.0f / %4.0f us   force %6.2f N   lost %llu   "
               "energy %+.4f J%s%s",
               terminal_ ? "\r" : "", status.time, rate, us * status.round_trip_p50,
               us * status.round_trip_p99, status.force,
               static_cast<unsigned long long>(status.lost), status.energy,
               !status.connected        ? "   reconnecting"
               : status.answered_lately ? ""
                                        : "   no answer",
               terminal_ ? "\x1b[K" : "\n");
  std::fflush(stderr);
  open_ = terminal_;
  shown_ = status.time;
  before_ = status;
}

void StatusLine::end() {
  if (open_) std::fputs("\n", stderr);
  open_ = false;
}

}  // namespace feltwire
