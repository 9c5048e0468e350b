// Tests a gamepad that the kernel creates (uinput): its event node, ioctls and events are real.
// Without uinput the test is skipped with a message.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "client/drivers/joystick/joystick_device.hpp"
#include "client/input_devices/input_nodes.hpp"
#include "client/input_devices/machine_files.hpp"

namespace feltwire::kernel_pad_test {
namespace {

namespace fs = std::filesystem;

constexpr int kFull = 32767;
constexpr std::uint16_t kVendor = 0x1209, kProduct = 0xFE17;  // an unused product id

struct KernelPad : ::testing::Test {
  void SetUp() override {
    uinput = ::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (uinput < 0) GTEST_SKIP() << "/dev/uinput: " << std::generic_category().message(errno);
    for (const int type : {EV_KEY, EV_ABS}) ASSERT_EQ(::ioctl(uinput, UI_SET_EVBIT, type), 0);
    for (const int key : {BTN_SOUTH, BTN_TL, BTN_TR})
      ASSERT_EQ(::ioctl(uinput, UI_SET_KEYBIT, key), 0);
    for (const unsigned code : {ABS_X, ABS_Y, ABS_RX, ABS_RY}) {
      uinput_abs_setup axis{};
      axis.code = static_cast<std::uint16_t>(code);
      axis.absinfo.minimum = -kFull - 1;
      axis.absinfo.maximum = kFull;
      axis.absinfo.flat = 128;
      ASSERT_EQ(::ioctl(uinput, UI_ABS_SETUP, &axis), 0);
    }
    uinput_setup setup{};
    setup.id = {.bustype = BUS_VIRTUAL, .vendor = kVendor, .product = kProduct, .version = 1};
    std::string("feltwire's test pad").copy(setup.name, sizeof setup.name - 1);
    ASSERT_EQ(::ioctl(uinput, UI_DEV_SETUP, &setup), 0);
    ASSERT_EQ(::ioctl(uinput, UI_DEV_CREATE), 0);
    std::array<char, 64> name{};
    ASSERT_GE(::ioctl(uinput, UI_GET_SYSNAME(sizeof name), name.data()), 0);
    for (const fs::path& entry : entries(fs::path("/sys/class/input") / name.data()))
      if (entry.filename().string().starts_with("event")) node = "/dev/input" / entry.filename();
    if (::access(node.c_str(), R_OK) != 0)
      GTEST_SKIP() << "the kernel's pad, '" << node.string()
                   << "': " << std::generic_category().message(errno);
  }
  ~KernelPad() override {
    if (uinput >= 0) ::close(uinput);  // The kernel then removes the gamepad.
  }
  void tell(std::uint16_t type, std::uint16_t code, int value) const {
    input_event event{};
    event.type = type;
    event.code = code;
    event.value = value;
    ASSERT_EQ(::write(uinput, &event, sizeof event), static_cast<ssize_t>(sizeof event));
  }

  int uinput = -1;
  fs::path node;
};

/// After write() the kernel has put the events into the node's buffer. No wait is necessary.
TEST_F(KernelPad, IsFoundTakenReadAndUnplugged) {
  const auto found = input_nodes(Machine{});
  const auto pad = std::ranges::find(found, node, &InputNode::node);
  ASSERT_NE(pad, found.end());
  EXPECT_EQ(pad->kind, "gamepad");
  EXPECT_EQ(pad->name, "feltwire's test pad");
  EXPECT_EQ(pad->vendor + ":" + pad->product, "1209:fe17");

  DeviceRequest request;
  request.name = node.string();
  const OpenedDevice opened = open_gamepad(request);
  // Only one program may open the gamepad.
  EXPECT_THROW(open_gamepad(request), std::runtime_error);
  opened.device->begin(Vec3::Zero(), Vec3::UnitZ());
  Nanoseconds now = std::chrono::seconds(7);
  const auto move = [&](int ticks) {
    DeviceReading reading;
    for (int n = 0; n < ticks; ++n) {
      now += std::chrono::milliseconds(1);
      reading = opened.device->read(now);
      opened.device->write({});
    }
    return reading;
  };
  const DeviceReading first = move(10);
  ASSERT_TRUE(first.ok);
  EXPECT_FALSE(first.deadman);
  tell(EV_ABS, ABS_X, kFull);
  tell(EV_KEY, BTN_TR, 1);
  tell(EV_SYN, SYN_REPORT, 0);
  const DeviceReading pushed = move(1000);
  EXPECT_TRUE(pushed.deadman);
  EXPECT_NEAR((pushed.pose.position - first.pose.position - Vec3(0, 0.1, 0)).norm(), 0.0, 0.005);

  ASSERT_EQ(::ioctl(uinput, UI_DEV_DESTROY), 0);
  EXPECT_FALSE(move(1).ok);
}

}  // namespace
}  // namespace feltwire::kernel_pad_test
