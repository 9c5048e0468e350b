// Tests the device list of feltwire-doctor on simulated machines.

#include "client/input_devices/usb_scan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace feltwire::usb_scan_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Builds a simulated tree of /sys, /dev and /proc.
class PluggedInTest : public ::testing::Test {
 protected:
  void put(const std::string& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text << "\n";
  }
  void plug(const std::string& port, const std::string& vendor, const std::string& product,
            const std::string& number) {
    const std::string folder = "sys/bus/usb/devices/" + port + "/";
    put(folder + "idVendor", vendor);
    put(folder + "idProduct", product);
    put(folder + "busnum", "1");
    put(folder + "devnum", number);
    put("dev/bus/usb/001/00" + number, "");
  }
  void hold(const std::string& process, const std::string& name, const std::string& node) {
    put("proc/" + process + "/comm", name);
    fs::create_directories(root_ / "proc" / process / "fd");
    fs::create_symlink(node, root_ / "proc" / process / "fd/5");
  }
  std::string seen(bool may = true) {
    return text(scan_usb({root_, [may](const fs::path&) { return may; }}));
  }

  test::TemporaryFolder folder_;
  fs::path root_ = folder_ / "machine";
};

TEST_F(PluggedInTest, AnEmptyMachineSaysSo) {
  EXPECT_THAT(seen(), HasSubstr("no haptic device that feltwire knows"));
}

TEST_F(PluggedInTest, KnowsADeviceAndItsDriverAndLeavesOthersOut) {
  plug("1-1", "1451", "0402", "4");
  put("sys/bus/usb/devices/1-1/product", "omega.x");
  plug("1-2", "046d", "c077", "5");  // a mouse
  const auto devices = scan_usb({root_, [](const fs::path&) { return true; }});
  ASSERT_EQ(devices.size(), 1u);
  EXPECT_EQ(devices[0].kind, "forcedimension");
  EXPECT_EQ(devices[0].nodes, std::vector<fs::path>{"/dev/bus/usb/001/004"});
  EXPECT_TRUE(devices[0].complaints.empty()) << text(devices);
  EXPECT_THAT(text(devices), HasSubstr("Force Dimension, \"omega.x\" (1451:0402)"));
}

TEST_F(PluggedInTest, ANodeThatMayNotBeOpenedHasARuleToPaste) {
  plug("1-1", "1451", "0402", "4");
  EXPECT_THAT(seen(false), HasSubstr("you may not open /dev/bus/usb/001/004"));
  EXPECT_THAT(seen(false), HasSubstr("ATTRS{idVendor}==\"1451\", ATTRS{idProduct}==\"0402\", "
                                     "TAG+=\"uaccess\""));
}

TEST_F(PluggedInTest, ASerialPortIsFoundAndWhoHoldsIt) {
  plug("1-3", "2988", "0302", "6");
  put("sys/bus/usb/devices/1-3/1-3:1.0/tty/ttyACM0/dev", "166:0");
  put("dev/ttyACM0", "");
  hold("812", "ModemManager", "/dev/ttyACM0");
  EXPECT_THAT(seen(), HasSubstr("/dev/ttyACM0 is held by ModemManager (process 812)"));
  EXPECT_THAT(seen(), HasSubstr("ID_MM_DEVICE_IGNORE"));
  EXPECT_THAT(seen(), Not(HasSubstr("may not open")));
}

TEST_F(PluggedInTest, AnotherProgramThatHoldsItIsNamed) {
  plug("1-1", "0403", "cb48", "4");
  hold("77", "HapticDesk", "/dev/bus/usb/001/004");
  EXPECT_THAT(seen(), HasSubstr("--device falcon"));
  EXPECT_THAT(seen(), HasSubstr("held by HapticDesk (process 77)"));
  EXPECT_THAT(seen(), HasSubstr("end that program"));
}

TEST_F(PluggedInTest, ANodeThatIsMissingIsSaid) {
  plug("1-1", "1451", "0402", "4");
  fs::remove(root_ / "dev/bus/usb/001/004");
  EXPECT_THAT(seen(), HasSubstr("/dev/bus/usb/001/004 is not there"));
}

TEST_F(PluggedInTest, NonsenseInTheTreeIsNoDeviceNode) {
  plug("1-1", "1451", "0402", "4");
  put("sys/bus/usb/devices/1-1/devnum", "../../etc");
  const auto devices = scan_usb({root_, [](const fs::path&) { return true; }});
  ASSERT_EQ(devices.size(), 1u);
  EXPECT_TRUE(devices[0].nodes.empty());
}

}  // namespace
}  // namespace feltwire::usb_scan_test
