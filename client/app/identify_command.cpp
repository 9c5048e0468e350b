#include "client/app/identify_command.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "client/app/device_settings.hpp"
#include "client/drivers/drivers.hpp"
#include "client/identify/identified_spec.hpp"
#include "client/identify/measure.hpp"
#include "client/run/crash_release.hpp"
#include "core/base/pending_file.hpp"
#include "core/base/visible_text.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {
namespace {

constexpr int kWrongWords = 2, kGaveUp = 1;
// Longest wait until a person has prepared the device.
constexpr Nanoseconds kPreparing = std::chrono::minutes(2);

struct IdentifyWords {
  std::string device, spec, out = "device.json";
  std::optional<double> force;
  bool yes = false;
};

MeasureStatus status_of_run;  // global, so that a signal handler can set `stop`
static_assert(std::atomic<bool>::is_always_lock_free);

void stop_run(int) { status_of_run.stop.store(true); }

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm date{};
  std::array<char, 16> text{};
  ::gmtime_r(&now, &date);
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &date);
  return text.data();
}

void tell(const IdentifyLimits& limits, const Identification& identification) {
  std::printf(
      "The device will move its handle by itself for %.0f s: up to %.0f mm to each side of where\n"
      "it is now, up to %.2f m/s, with up to %.1f N. Nobody may hold it. Attach the tool that you "
      "use\nwith it, switch its gravity compensation on and the maker's own damping off, and clear "
      "%.0f mm\naround it. The force ends on Ctrl-C and on every fault.\n",
      identification.duration(), 1e3 * limits.amplitude, limits.speed, limits.force,
      1e3 * limits.travel);
}

void await_consent(bool yes) {
  if (yes) return;
  if (::isatty(STDIN_FILENO) == 0)
    throw std::invalid_argument("the input is no terminal, so nobody can press Enter; give --yes");
  std::printf("Press Enter to begin, Ctrl-C to cancel. ");
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line))
    throw std::runtime_error(
        "the input ended before Enter; start the command again, or give --yes");
}

void tell_no_force(std::string_view why) {
  std::fprintf(stderr, "feltwire-client identify: no force yet: %s\n", visible(why).c_str());
}

/// Prints the progress until the measurement ends. On a terminal, the progress stays in one line.
void show_progress(const MeasureStatus& status) {
  const bool terminal = ::isatty(STDERR_FILENO) != 0;
  int shown = -1;
  std::string_view told;
  while (!status.over.load()) {
    if (const std::string_view awaits = status.awaits.load(); awaits != told) {
      if (!awaits.empty()) tell_no_force(awaits);
      told = awaits;
    }
    const int percent = static_cast<int>(100.0 * status.progress.load());
    if (percent != shown && (terminal || percent % 10 == 0)) {
      std::fprintf(stderr, terminal ? "\r%3d %%  line %d " : "%3d %%  line %d\n", percent,
                   status.sweep.load() + 1);
      shown = percent;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  if (terminal) std::fprintf(stderr, "\r                    \r");
}

/// Prints the measured lag of the control loop and its upper bound.
void tell_lag(const DeviceEstimate& found) {
  if (!found.lag_bound)
    std::printf("  lag of the loop       not found: the readings do not tell it\n");
  else
    std::printf("  lag of the loop       %.3f ms, at most %.3f ms\n", 1e3 * found.lag,
                1e3 * *found.lag_bound);
}

/// Prints the measured transmission.
void tell_transmission(const DeviceEstimate& found) {
  if (!found.transmission) {
    std::printf("  transmission          not found: no resonance in reach of the readings\n");
    return;
  }
  const TransmissionFit& fit = *found.transmission;
  std::printf("  transmission          resonance %.1f Hz, at least %.0f N/m, encoder at the %s\n",
              fit.resonance, fit.stiffness_bound,
              std::string(kEncoderSideNames[static_cast<std::size_t>(fit.side)]).c_str());
}

/// Measures the device, then releases it, also after an error or a signal.
void run(Device& device, Identification& identification) {
  MeasureStatus& status = status_of_run;
  const CrashRelease crash_release(device);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(signal, stop_run);
  device.begin(Vec3::Zero(), Vec3::UnitZ());
  RealTime granted;
  std::thread ticks([&] {
    granted = request_real_time(kServoPriority);
    measure(device, identification, status);
  });
  std::thread watching([&] {
    if (watch(device, status)) return;
    std::fputs(
        "feltwire-client identify: the device's library hangs; the force was taken off. Plug the "
        "device in again\n",
        stderr);
    std::_Exit(kGaveUp);
  });
  show_progress(status);
  ticks.join();
  watching.join();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(signal, SIG_DFL);
  if (const std::string remedy = missing(granted, kServoPriority); !remedy.empty())
    std::fprintf(stderr, "feltwire-client identify: note: %s\n", visible(remedy).c_str());
}

void identify(const IdentifyWords& words) {
  BareDevice bare = bare_device(words.device);
  if (!bare.driver->gives_force)
    throw std::invalid_argument(
        "--device " + std::string(bare.driver->kind) +
        ": it gives no force, so it cannot be measured; name a device that gives force");
  DeviceRequest& request = bare.request;
  request.spec.name_or_file = words.spec;
  request.held = false;
  if (is_special(words.out))
    throw std::invalid_argument("--out " + words.out +
                                ": it is not a regular file; give the path of a regular file");

  const OpenedDevice opened = bare.driver->open(request);
  Device& device = *opened.device;
  for (const std::string& note : opened.notes)
    std::fprintf(stderr, "feltwire-client identify: note: %s\n", visible(note).c_str());
  await_prepared(device, kPreparing, tell_no_force);
  const SourcedSpec known =
      reported_spec(requested_spec(request.spec, bare.driver->spec), device.spec());
  const IdentifyLimits limits = identify_limits(known.spec, words.force);
  const double longest = std::chrono::duration<double>(device.longest_tick()).count();
  // A device that sets the tick rate may tick at up to 4 kHz, faster than the rate that it
  // guarantees.
  Identification identification(known.spec, limits, longest > 0.0 ? 0.25e-3 : kMeasurePeriod);
  tell(limits, identification);
  await_consent(words.yes);
  run(device, identification);
  if (identification.state() != Identification::State::done)
    throw std::runtime_error("the measurement was stopped: " + std::string(identification.why()));

  const DeviceEstimate found = identification.estimate();
  if (!found.doubts.empty())
    throw std::runtime_error("the measurement is doubtful, so no file was written: " +
                             found.doubts.front());
  const SourcedSpec described = identified_spec(known, found, today());
  std::printf("%s", visible_lines(spec_table(described)).c_str());
  tell_lag(found);
  tell_transmission(found);
  std::printf("  largest force held    %.2f N\n", identification.largest_force());
  for (int i = 0; i < known.spec.translation_dof; ++i) {
    std::printf("  damping along %c       %.3g N s/m by the sweeps, ", "xyz"[i], found.damping[i]);
    if (const auto decay = found.decay[static_cast<std::size_t>(i)])
      std::printf("%.3g by the decay\n", *decay);
    else
      std::printf("and the handle stops too soon for a decay\n");
  }
  if (!(found.damping_bound.minCoeff() > 0.0))
    std::printf(
        "The damping is too small to separate it from friction and noise. The file has 0.\n");
  if (const double late = late_time(known.spec, found); found.lag_bound && *found.lag_bound < late)
    std::fprintf(stderr,
                 "feltwire-client identify: warning: late_ticks %d are %.2f ms, but a force acts "
                 "after %.2f ms at most. Put late_ticks 0 and actuation_lag %.6f in their place\n",
                 known.spec.actuation.late_ticks, 1e3 * late, 1e3 * *found.lag_bound,
                 *found.lag_bound);
  replace_file(words.out, device_file_text(described), kByUmask);
  std::printf("%s was written; use it with --spec %s\n", visible(words.out).c_str(),
              visible(words.out).c_str());
}

int failed(const std::string& why, int status) {
  std::fprintf(stderr, "feltwire-client identify: %s\n", printable_error(why).c_str());
  return status;
}

}  // namespace

int identify_command(int argc, char** argv) {
  CLI::App app("Measures a device that nobody holds, and writes a file for --spec",
               "feltwire-client identify");
  IdentifyWords words;
  app.add_option(
         "--device", words.device,
         "KIND or KIND:NAME. " + driver_choices() + ". A Falcon may need falcon:firmware=FILE")
      ->required();
  app.add_option("--spec", words.spec,
                 "Known specification of the device: a built-in name or FILE.json. Its largest "
                 "force and workspace limit the measurement");
  app.add_option("--out", words.out, "FILE.json for the measured specification")
      ->capture_default_str();
  app.add_option(
      "--force", words.force,
      "[N] Largest force of the measurement. Default: 15 % of the device's largest force");
  app.add_flag(
      "--yes", words.yes,
      "Start without a question. Nobody may hold the device, and its workspace must be clear");
  try {
    check_words(app, argc, argv, {{"firmware", "--device falcon:firmware=FILE"}});
    parse_arguments(app, argc, argv);
    identify(words);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return failed(error.what() + advice(error, app) + "; see --help", kWrongWords);
  } catch (const std::invalid_argument& error) {
    return failed(error.what(), kWrongWords);
  } catch (const std::exception& error) {
    return failed(error.what(), kGaveUp);
  }
}

}  // namespace feltwire
