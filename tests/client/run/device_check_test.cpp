// The check counts the ticks of a device and gives a verdict. docs/devices.md has the limits.

#include "client/run/device_check.hpp"

#include <gmock/gmock.h>

#include <deque>

#include "core/device/spec_text.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire::device_check_test {
namespace {

using ::testing::HasSubstr;

/// Returns ticks from a script without waiting: 'n' new reading, 'o' old, 'f' fault, 'm' no tick.
class Scripted final : public Device {
 public:
  explicit Scripted(std::string script, bool paced = true)
      : script_(std::move(script)), paced_(paced) {}

  const DeviceSpec& spec() const override { return spec_; }
  Nanoseconds longest_tick() const override { return std::chrono::seconds(paced_ ? 60 : 0); }
  bool await_tick(Nanoseconds) noexcept override {
    if (next() != 'm') return true;
    ++at;
    return false;
  }
  DeviceReading read(Nanoseconds) noexcept override {
    const char what = next();
    ++at;
    return {.pose = {}, .ok = what != 'f', .fresh = what != 'o'};
  }
  Command write(const Command& on_hand) noexcept override {
    ++writes;
    most = std::max(most, on_hand.force().norm() + on_hand.torque.norm());
    return on_hand;
  }
  void release() noexcept override { released = true; }

  std::size_t at = 0;
  int writes = 0;
  double most = 0.0;
  bool released = false;

 private:
  char next() const { return script_[at % script_.size()]; }

  std::string script_;
  bool paced_;
  DeviceSpec spec_ = sourced_spec("touch").spec;
};

CheckResult of(const DeviceTicks& ticks, std::string_view what) {
  for (const CheckResult& result : judge(ticks))
    if (result.what == what) return result;
  return {.what = "none", .figure = {}, .remedy = {}};
}

TEST(DeviceCheck, CountsWhatTheDeviceDoesAndPutsNoForceOnTheHand) {
  Scripted device("nnofm");
  const DeviceTicks ticks = watch_ticks(device, 0.05, 1000.0);
  EXPECT_TRUE(device.released);
  EXPECT_EQ(device.most, 0.0);
  ASSERT_GT(device.at, 10u);
  const auto whole = static_cast<double>(ticks.ticks + ticks.missed);
  EXPECT_EQ(whole, static_cast<double>(device.at));
  const auto part = [&](std::uint64_t count) { return static_cast<double>(count); };
  EXPECT_NEAR(part(ticks.missed), 0.2 * whole, 1.0);
  EXPECT_NEAR(part(ticks.repeated), 0.2 * whole, 1.0);
  EXPECT_NEAR(part(ticks.faults), 0.2 * whole, 1.0);
  // The servo must skip old readings and write nothing for them.
  EXPECT_EQ(static_cast<std::uint64_t>(device.writes), ticks.ticks - ticks.repeated);
  EXPECT_EQ(ticks.overlong, 0u);
  EXPECT_GT(ticks.span, 0.0);
}

TEST(DeviceCheck, ADeviceWithoutAPaceIsReadAtTheGivenRate) {
  Scripted device("n", false);
  const DeviceTicks ticks = watch_ticks(device, 0.2, 100.0);
  EXPECT_LE(ticks.ticks, 21u);
  EXPECT_GE(ticks.interval.quantile(0.5), 5e6);
  EXPECT_EQ(of(ticks, "longest tick").what, "none");
}

TEST(DeviceCheck, JudgesByTheLimits) {
  DeviceTicks ticks{.span = 1.0, .longest_tick = 1.25e-3, .ticks = 1000};
  for (int i = 0; i < 999; ++i) ticks.interval.record(1000000);
  for (const char* what : {"rate", "jitter", "longest tick", "readings", "faults"}) {
    EXPECT_EQ(of(ticks, what).verdict, Verdict::pass) << what;
    EXPECT_EQ(of(ticks, what).remedy, "") << what;
  }
  EXPECT_THAT(of(ticks, "rate").figure, HasSubstr("1000.0 ticks a second, 0 missed"));
  ticks.missed = 1;
  EXPECT_EQ(of(ticks, "rate").verdict, Verdict::warn);
  ticks.missed = 20;
  EXPECT_EQ(of(ticks, "rate").verdict, Verdict::fail);
  ticks.overlong = 2;
  EXPECT_EQ(of(ticks, "longest tick").verdict, Verdict::warn);
  EXPECT_THAT(of(ticks, "longest tick").figure,
              HasSubstr("2 of 1000 ticks longer than the 1.25 ms"));
  ticks.overlong = 51;
  EXPECT_EQ(of(ticks, "longest tick").verdict, Verdict::fail);
  ticks.repeated = 500;
  EXPECT_EQ(of(ticks, "readings").verdict, Verdict::warn);
  EXPECT_THAT(of(ticks, "readings").remedy, HasSubstr("--rate 500"));
  ticks.faults = 1;
  EXPECT_EQ(of(ticks, "faults").verdict, Verdict::fail);
  for (int i = 0; i < 11; ++i) ticks.interval.record(1300000);
  EXPECT_EQ(of(ticks, "jitter").verdict, Verdict::warn);
  for (int i = 0; i < 30; ++i) ticks.interval.record(2100000);
  EXPECT_EQ(of(ticks, "jitter").verdict, Verdict::fail);
}

/// A device that never ticks must fail in each figure.
TEST(DeviceCheck, NoTickIsNoGoodDevice) {
  for (const char* what : {"rate", "jitter", "readings", "faults"})
    EXPECT_EQ(of({.span = 1.0}, what).verdict, Verdict::fail) << what;
}

}  // namespace
}  // namespace feltwire::device_check_test
