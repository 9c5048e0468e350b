#include "client/run/check.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/units.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {
namespace {

constexpr double kNanoseconds = 1e9;

const char* const kQuietMachine =
    "give the client a machine with less to do, the rights of docs/devices.md (real-time "
    "scheduling), or a lower --rate";

CheckResult session(const RunFigures& run) {
  const bool whole = run.end == EndReason::duration || run.end == EndReason::requested;
  return check_result(
      "session", whole ? Verdict::pass : Verdict::fail,
      whole ? figure(run.duration, 1) + " s" : "ended early: " + std::string(name(run.end)),
      "the last lines of the client and the server's log say why");
}

CheckResult rate(const RunFigures& run) {
  constexpr double kPasses = 0.001, kWorks = 0.05;  // limits of the share of missed ticks
  const double wanted = 1.0 / run.servo_period;
  const auto due = static_cast<double>(run.samples + run.missed_deadlines);
  const double missing = due > 0.0 ? static_cast<double>(run.missed_deadlines) / due : 1.0;
  return check_result(
      "rate", rising(missing, kPasses, kWorks),
      figure((1.0 - missing) * wanted, 1) + " of " + figure(wanted, 0) + " ticks a second",
      kQuietMachine);
}

CheckResult wakeups(const RunFigures& run) {
  constexpr double kPasses = 0.1, kWorks = 0.5;  // limits of the lateness, in servo periods
  const double late = run.wakeup_late.quantile(0.99) / kNanoseconds;
  return check_result("late wake-ups", rising(late / run.servo_period, kPasses, kWorks),
                      "99 % of ticks within " + figure(kMicro * late, 0) + " us, the worst " +
                          figure(static_cast<double>(run.wakeup_late.max()) / kMilli, 0) + " us",
                      kQuietMachine);
}

/// Warns of deep sleep states of the processors only if ticks are late.
CheckResult processors(const RunFigures& run, const MachineFacts& machine) {
  constexpr int kShort = 50;  // [us] longest wake-up time of a shallow sleep
  const bool late = wakeups(run).verdict != Verdict::pass;
  const bool deep = !machine.wake_latency || *machine.wake_latency > kShort;
  const std::string figure = !machine.wake_latency ? "/dev/cpu_dma_latency may not be read"
                             : *machine.wake_latency > kShort
                                 ? "may sleep deeply"
                                 : "wake within " + std::to_string(*machine.wake_latency) + " us";
  return check_result(
      "processors", late && deep ? Verdict::warn : Verdict::pass, figure,
      "keep them from deep sleep: tuned-adm profile latency-performance, or a program "
      "that holds /dev/cpu_dma_latency open with 0 in it");
}

CheckResult clock(const MachineFacts& machine) {
  constexpr std::array<std::string_view, 3> kSlow = {"hpet", "acpi_pm", "jiffies"};
  constexpr double kPasses = 1e-6, kWorks = 1e-4;  // [s] limits of the clock resolution
  const bool slow = std::ranges::find(kSlow, machine.clock_source) != kSlow.end();
  const Verdict verdict = rising(machine.clock_resolution, kPasses, kWorks);
  return check_result(
      "clock", slow ? std::max(verdict, Verdict::warn) : verdict,
      (machine.clock_source.empty() ? "unknown source" : machine.clock_source) + ", " +
          figure(kNanoseconds * machine.clock_resolution, 0) + " ns",
      "boot the kernel with clocksource=tsc where the processor has a steady one, or a "
      "kernel with high resolution timers");
}

CheckResult answers(const RunFigures& run) {
  return check_result(
      "answers", run.round_trip.count() > 0 ? Verdict::pass : Verdict::fail,
      std::to_string(run.round_trip.count()) + " of " + std::to_string(run.datagrams),
      "the control port answers and the scene's does not: open its udp port, which the "
      "server's listening: line names, in every firewall on the way");
}

const char* const kLongLine =
    "a line with less to do, or --traffic wan with the local model; a longer --hold-time lets "
    "older commands count";

CheckResult round_trip(const RunFigures& run) {
  // Limits of the round trip as shares of the hold time. Above half of the hold time, commands
  // fade.
  constexpr double kPasses = 0.25, kWorks = 0.5;
  const double p50 = run.round_trip.quantile(0.5) / kNanoseconds;
  const double p99 = run.round_trip.quantile(0.99) / kNanoseconds;
  return check_result("round trip", rising(p99 / run.hold_time, kPasses, kWorks),
                      "half within " + figure(kMilli * p50, 2) + " ms, 99 % within " +
                          figure(kMilli * p99, 2) + " ms",
                      kLongLine);
}

CheckResult jitter(const RunFigures& run) {
  constexpr double kWorks = 0.125;  // limit of the jitter as a share of the hold time
  const double passes = std::max(run.servo_period, kWorks / 4.0 * run.hold_time);
  return check_result(
      "jitter", rising(*run.jitter, passes, kWorks * run.hold_time),
      figure(kMilli * *run.jitter, 2) + " ms from one datagram to the next",
      "a cable instead of radio; --dscp, where the network heeds it; --traffic wan");
}

CheckResult loss(const RunFigures& run) {
  constexpr double kPasses = 0.001, kWorks = 0.05;
  const double share = static_cast<double>(run.lost) / static_cast<double>(run.datagrams);
  return check_result(
      "loss", rising(share, kPasses, kWorks),
      figure(kPercent * share, 2) + " % of " + std::to_string(run.datagrams) + " datagrams",
      "--traffic redundancy=2 repeats samples; a cable instead of radio; less traffic beside it");
}

CheckResult datagram_size(const RunFigures& run, const MachineFacts& machine) {
  constexpr int kUdp = 8, kIpv4 = 20, kIpv6 = 40;  // [bytes] header sizes
  const int needed = static_cast<int>(kMaxDatagram) + kUdp + (machine.ipv6 ? kIpv6 : kIpv4);
  const bool small = !machine.path_mtu || *machine.path_mtu < needed;
  return check_result(
      "datagram size",
      run.too_long > 0 || run.shortened > 0 ? Verdict::fail
      : small                               ? Verdict::warn
                                            : Verdict::pass,
      (machine.path_mtu ? "packets of " + std::to_string(*machine.path_mtu) + " bytes"
                        : std::string("not known")) +
          ", " + std::to_string(needed) + " needed at most" +
          (run.shortened > 0 ? "; " + std::to_string(run.shortened) + " replies came shortened"
                             : std::string()),
      "an MTU of " + std::to_string(needed) +
          " or more on every interface and tunnel of the way; until then fewer samples a "
          "datagram (batch and redundancy of --traffic)");
}

}  // namespace

std::vector<CheckResult> judge(const RunFigures& run, const MachineFacts& machine) {
  std::vector<CheckResult> results = {session(run),
                                      rate(run),
                                      wakeups(run),
                                      permissions(run.real_time),
                                      processors(run, machine),
                                      clock(machine),
                                      answers(run)};
  if (run.round_trip.count() > 0) {
    results.push_back(round_trip(run));
    if (run.jitter) results.push_back(jitter(run));
    results.push_back(loss(run));
  }
  results.push_back(datagram_size(run, machine));
  return results;
}

}  // namespace feltwire
