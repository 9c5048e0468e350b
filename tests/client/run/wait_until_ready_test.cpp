#include "client/run/wait_until_ready.hpp"

#include <gtest/gtest.h>

#include <csignal>

namespace feltwire::wait_until_ready_test {
namespace {

struct Waiting final : Device {
  DeviceSpec described = builtin_device("simulated");
  int asked = 0, ready_after = 3;
  const DeviceSpec& spec() const override { return described; }
  std::string_view prepare() noexcept override {
    if (asked == 2 && ready_after > 100) ::raise(SIGINT);
    return ++asked > ready_after ? "" : "pull the handle out";
  }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command&) noexcept override { return {}; }
  void release() noexcept override {}
};

TEST(WaitUntilReady, WaitsUntilTheDeviceIsReadyAndSaysWhatToDo) {
  const Signals signals;
  Waiting device;
  ::testing::internal::CaptureStderr();
  EXPECT_TRUE(wait_until_ready(device, signals));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "feltwire-client: no force yet: pull the handle out\n");
  EXPECT_EQ(device.asked, 4);
}

TEST(WaitUntilReady, ASignalEndsTheWait) {
  const Signals signals;
  Waiting device;
  device.ready_after = 1000;
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(wait_until_ready(device, signals));
  ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(device.asked, 3);
}

}  // namespace
}  // namespace feltwire::wait_until_ready_test
