#include "client/run/device_words.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/units.hpp"

namespace feltwire {
namespace {

constexpr double kSecondsInNanosecond = 1e-9;
constexpr std::size_t kLongestWords = 512;  // [characters]

}  // namespace

std::string slow_device(const DeviceTimes& times, double period, bool paced) {
  constexpr double kMost = 0.99, kSlow = 0.5, kRoom = 0.5;
  const double read = kSecondsInNanosecond * times.read.quantile(kMost);
  const double write = kSecondsInNanosecond * times.write.quantile(kMost);
  if (!(std::max(read, write) > kSlow * period)) return {};
  std::array<char, kLongestWords> text{};
  std::snprintf(text.data(), text.size(),
                "the device's %s takes %.1f ms, and a tick has %.1f ms: ticks come late, and the "
                "force is old and less; %s",
                read >= write ? "read()" : "write()", kMilli * std::max(read, write),
                kMilli * period,
                paced ? "let its driver wait in await_tick(), and call it in a thread of its own"
                      : "let a thread of its driver call it, or give ");
  std::string all = text.data();
  if (paced) return all;
  std::snprintf(text.data(), text.size(), "--rate %.0f",
                std::max(1.0, std::floor(kRoom / (read + write))));
  return all + text.data();
}

std::string device_faults_text(std::uint64_t faults, std::uint64_t jumps) {
  if (faults == 0) return {};
  const auto many = [](std::uint64_t n, const std::string& what) {
    return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
  };
  std::string text = ", " + many(faults, "device fault");
  if (jumps > 0) text += " (" + many(jumps, "jump") + " of its position)";
  return text;
}

std::string trouble_text(const std::optional<Servo::DeviceTrouble>& trouble, double end) {
  if (!trouble) return {};
  const bool silent = trouble->reason == ZeroForceReason::device_fault;
  std::array<char, kLongestWords> text{};
  std::snprintf(
      text.data(), text.size(), "the device failed at %.1f s, and there was no force any more: %s",
      std::max(0.0, end - trouble->time),
      silent ? "it gives no position; see its cable, its power and its driver's log, then start "
               "again"
             : "it does not hold the force that it is given; see its power, its switches and its "
               "driver's log, then start again");
  return text.data();
}

}  // namespace feltwire
