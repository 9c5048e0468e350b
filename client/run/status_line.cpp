#include "client/run/status_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "client/run/device_words.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

constexpr double kNanosecondsInUs = 1e-3, kSecondsInUs = 1e6;
constexpr std::size_t kLongest = 256;  // [characters] longest line

std::string one_way(const char* way, double delay, double jitter, bool known) {
  std::array<char, kLongest> part{};
  if (!known) return std::string(way) + " -";
  std::snprintf(part.data(), part.size(), "%s %.0f+-%.0f", way, kSecondsInUs * delay,
                kSecondsInUs * jitter);
  return part.data();
}

/// Returns the share of the samples that were lost between two states [%]. Late answers may raise
/// it temporarily.
double loss(const LiveStatus& status, const LiveStatus& before) {
  const double samples = static_cast<double>(status.samples - before.samples);
  const double lost =
      static_cast<double>(status.network.lost - std::min(status.network.lost, before.network.lost));
  return samples > 0.0 ? kPercent * std::min(lost / samples, 1.0) : 0.0;
}

/// Returns a text such as "  oscillation 3 um  stiffness 487 N/m". Omits unmeasured values.
std::string feel(const LiveStatus& status, const LiveStatus& before) {
  constexpr double kMicrometres = 1e6;
  std::string line;
  std::array<char, kLongest> part{};
  if (const auto rms = status.oscillation.since(before.oscillation).rms()) {
    std::snprintf(part.data(), part.size(), "  oscillation %.1f um", kMicrometres * *rms);
    line += part.data();
  }
  if (status.displayed_stiffness) {
    std::snprintf(part.data(), part.size(), "  stiffness %.0f N/m", *status.displayed_stiffness);
    line += part.data();
  }
  return line;
}

/// Returns a text such as "  shaped late, 1.20 N s/m of the hand", "  shaped near, 85 % of the
/// force" or "  shaped near, asked 0.30 ms farther ahead".
std::string shaping(const LiveStatus& s) {
  if (!s.shapes) return {};
  std::string line = s.near ? "  shaped near" : "  shaped late";
  if (!s.hand_credit) return line;
  constexpr double kHalfPercent = 0.005;
  std::array<char, kLongest> part{};
  const HandCredit& hand = *s.hand_credit;
  if (s.near && hand.near_share < 1.0 - kHalfPercent) {
    std::snprintf(part.data(), part.size(), ", %.0f %% of the force", kPercent * hand.near_share);
    line += part.data();
  }
  if (s.near && hand.untold_lag > 0.0) {
    std::snprintf(part.data(), part.size(), ", asked %.2f ms farther ahead",
                  kMilli * hand.untold_lag);
    line += part.data();
  }
  if (!s.near && hand.damping > 0.0) {
    std::snprintf(part.data(), part.size(), ", %.2f N s/m of the hand", hand.damping);
    line += part.data();
  }
  return line;
}

/// Returns a text such as "  account +0.0120 J, cuts 34 % of the ticks".
std::string account(const LiveStatus& s, const LiveStatus& before) {
  if (!s.account.balance) return {};
  std::array<char, kLongest> part{};
  std::snprintf(part.data(), part.size(), "  account %+.4f J", *s.account.balance);
  std::string line = part.data();
  if (s.account.cuts > before.account.cuts && s.samples > before.samples) {
    const double cut = static_cast<double>(s.account.cuts - before.account.cuts);
    const double ticks = static_cast<double>(s.samples - before.samples);
    std::snprintf(part.data(), part.size(), ", cuts %.0f %% of the ticks",
                  kPercent * std::min(cut / ticks, 1.0));
    line += part.data();
  }
  return line;
}

/// Returns a text such as "  contact cut off in 34 % of the ticks" if the contact exceeds the time
/// limit of a tick.
std::string cut_contact(const LiveStatus& s, const LiveStatus& before) {
  if (s.contact_cuts <= before.contact_cuts || s.samples <= before.samples) return {};
  std::array<char, kLongest> part{};
  const double cut = static_cast<double>(s.contact_cuts - before.contact_cuts);
  const double ticks = static_cast<double>(s.samples - before.samples);
  std::snprintf(part.data(), part.size(), "  contact cut off in %.0f %% of the ticks",
                kPercent * std::min(cut / ticks, 1.0));
  return part.data();
}

/// Returns a text such as "  robot left aligning, turn by 0.42 rad".
std::string robot(const LiveStatus& s) {
  if (!s.robot.state) return {};
  std::string line = "  robot ";
  if (!s.robot.name.empty()) line += visible(s.robot.name) + " ";
  line += name(*s.robot.state);
  if (*s.robot.state != LinkState::aligning || !s.robot.turn) return line;
  std::array<char, kLongest> part{};
  std::snprintf(part.data(), part.size(), ", turn by %.2f rad", *s.robot.turn);
  return line + part.data();
}

/// Returns the device faults and the time of slow device calls, or an empty text.
std::string device(const LiveStatus& s, const LiveStatus& before) {
  std::string line = device_faults_text(s.device.faults, s.device.jumps);
  if (!line.empty()) line.replace(0, 1, " ");
  if (s.device.slow_ticks <= before.device.slow_ticks) return line;
  std::array<char, kLongest> part{};
  std::snprintf(part.data(), part.size(),
                "  the device is slow: its calls took %.1f ms of a tick (docs/devices.md)",
                kMilli * s.device.took);
  return line + part.data();
}

std::string ending(const LiveStatus& s) {
  if (!s.connected) return "  reconnecting";
  if (s.no_force != ZeroForceReason::felt) return "  no force: " + std::string(text(s.no_force));
  if (!s.answered_lately) return "  no answer";
  if (s.scene.recovering) return "  what moves was put back";
  return s.scene.withholds_change
             ? "  the scene has changed: let go and touch anew to feel all of it"
             : "";
}

}  // namespace

std::string text(const LiveStatus& s, const LiveStatus& before) {
  const double elapsed = s.time - before.time;
  const double rate =
      elapsed > 0.0 ? static_cast<double>(s.samples - before.samples) / elapsed : 0.0;
  const std::string up =
      one_way("up", s.network.delay_up, s.network.jitter_up, s.network.clock_known);
  const std::string down =
      one_way("down", s.network.delay_down, s.network.jitter_down, s.network.clock_known);
  std::array<char, kLongest> line{};
  std::snprintf(line.data(), line.size(),
                "%7.1f s %5.0f Hz  round trip %.0f/%.0f  %s  %s us  lost %.1f %%  force %5.2f N  "
                "energy %+.4f J",
                s.time, rate, kNanosecondsInUs * s.network.round_trip_p50,
                kNanosecondsInUs * s.network.round_trip_p99, up.c_str(), down.c_str(),
                loss(s, before), s.force, s.energy);
  return line.data() + feel(s, before) + shaping(s) + cut_contact(s, before) + account(s, before) +
         robot(s) + device(s, before) + ending(s);
}

std::string no_force_text(const ServoStatistics& statistics) {
  if (statistics.max_force >= kFeltForce) return {};
  return " (no force: " + std::string(text(prevailing(statistics.no_force))) + ")";
}

std::string cut_text(const ServoStatistics& statistics) {
  if (statistics.local_model.contact_cut == 0) return {};
  return ", contact cut off in " + std::to_string(statistics.local_model.contact_cut) + " ticks";
}

std::string feel_text(const FeelMetrics& measures) {
  constexpr double kMicrometres = 1e6;
  std::array<char, kLongest> part{};
  std::string line;
  if (const auto rms = measures.oscillation()) {
    std::snprintf(part.data(), part.size(), ", oscillation %.1f um", kMicrometres * *rms);
    line += part.data();
  }
  if (const auto stiffness = measures.displayed_stiffness()) {
    std::snprintf(part.data(), part.size(), ", displayed stiffness %.0f N/m", *stiffness);
    line += part.data();
  }
  return line;
}

StatusLine::StatusLine() : terminal_(::isatty(STDERR_FILENO) == 1) {}

void StatusLine::show(const LiveStatus& status, std::string_view more) {
  constexpr double kEvery = 1.0;  // [s] interval between two lines if the output is no terminal
  if (!terminal_ && shown_ >= 0.0 && status.time - shown_ < kEvery) return;
  const std::string line = text(status, before_).append(more);
  std::fprintf(stderr, "%s%s%s", terminal_ ? "\r" : "", line.c_str(), terminal_ ? "\x1b[K" : "\n");
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
