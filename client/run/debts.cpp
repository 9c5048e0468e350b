#include "client/run/debts.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <mutex>

#include "core/base/units.hpp"

namespace feltwire {
namespace {

struct Debts {
  std::mutex mutex;
  std::map<std::string, double> by_device;  // [J]
};
Debts& debts() {
  static Debts all;
  return all;
}

}  // namespace

std::string text(const Overdraft& overdraft, const DeviceSpec& spec) {
  std::array<char, 256> line{};
  const bool small = overdraft.debt < 1e-3;
  std::snprintf(line.data(), line.size(),
                "the force was ended: the hand got %.3g %s more energy than the device had burned, "
                "in a tick that held its force for %.3g ms",
                (small ? kMicro : kMilli) * overdraft.debt, small ? "uJ" : "mJ",
                kMilli * overdraft.hold_time);
  std::string told = line.data();
  if (!overdraft.strong_hand) return told + "; docs/bounding.md: \"Debts\"";
  std::snprintf(line.data(), line.size(),
                "; it was pushed by more than hand_force (%.3g N) of the device, or faster than "
                "hand_speed; docs/bounding.md: \"Debts\"",
                spec.hand_force);
  return told + line.data();
}

double debt_of(const std::string& device) {
  Debts& all = debts();
  const std::lock_guard lock(all.mutex);
  return all.by_device[device];
}

void settle_debt(const std::string& device, double before, double after) {
  Debts& all = debts();
  const std::lock_guard lock(all.mutex);
  double& debt = all.by_device[device];
  debt = std::max(0.0, debt + (after - before));
}

}  // namespace feltwire
