// Tests which input devices are found, opened or refused, and the messages.

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "client/input_devices/input_nodes.hpp"
#include "tests/devices/joystick_hand.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::input_node_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Steered;

TEST_F(Steered, IsTakenForThisProgramAlone) {
  gamepad();
  EXPECT_EQ(input.grabs, 1);
}

TEST_F(Steered, WhatCannotBeUsedIsSaid) {
  stand_in::be_xpad(input);
  EXPECT_THAT(refusal("spacemouse"), HasSubstr("it is a gamepad; use --device gamepad"));
  input.held_by_other = true;
  EXPECT_THAT(refusal("gamepad"), AllOf(HasSubstr("another program"), HasSubstr("spacenavd")));
  input.held_by_other = false;
  input.axes[ABS_Y].most = input.axes[ABS_Y].least;
  EXPECT_THAT(refusal("gamepad"), AllOf(HasSubstr("no range"), HasSubstr("calibrate")));
  input.is_event_node = false;
  EXPECT_THAT(refusal("gamepad"), HasSubstr("no event node"));
}

TEST_F(Steered, OtherInputDevicesAreRefused) {
  input.keys = {KEY_A, KEY_ENTER};
  EXPECT_THAT(refusal("gamepad"), HasSubstr("neither a gamepad nor a 3D mouse"));
  stand_in::be_spacemouse(input);
  input.keys = {};  // A gamepad's gyroscope has no keys.
  EXPECT_THAT(refusal("spacemouse"), HasSubstr("neither"));
  input.keys = {BTN_TRIGGER, BTN_THUMB};  // a flight stick
  EXPECT_THAT(refusal("spacemouse"), HasSubstr("neither"));
}

std::string path_refusal(const std::filesystem::path& path) {
  try {
    const EventNode node(path);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "none";
}

TEST(EventNode, WhatIsNoNodeIsSaid) {
  EXPECT_THAT(path_refusal("/dev/input/no_such"), AllOf(HasSubstr("no_such"), HasSubstr("check")));
  EXPECT_THAT(path_refusal("/dev/null"), AllOf(HasSubstr("/dev/null"), HasSubstr("no event node")));
}

/// During its life, removes root's right to open every file.
class AsNobody {
 public:
  AsNobody() : root_(::geteuid() == 0) {
    if (root_ && ::seteuid(65534) != 0) root_ = false;
  }
  ~AsNobody() {
    if (root_ && ::seteuid(0) != 0) std::abort();
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  bool root_;
};

TEST(EventNode, ANodeThatMayNotBeOpenedHasARemedy) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "event5") << "";
  ::chmod((folder / "event5").c_str(), 0);
  const AsNobody nobody;
  EXPECT_THAT(path_refusal(folder / "event5"),
              AllOf(HasSubstr("Permission denied"), HasSubstr("adduser $USER input")));
}

/// Builds a simulated machine.
struct Nodes : ::testing::Test {
  void put(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text << "\n";
  }
  void plug(const std::string& event, const std::string& name, const std::string& key,
            const std::string& abs) {
    const std::string device = "sys/class/input/" + event + "/device/";
    put(device + "name", name);
    put(device + "id/vendor", "256f");
    put(device + "id/product", "c635");
    put(device + "capabilities/key", key);
    put(device + "capabilities/abs", abs);
    put(device + "capabilities/rel", "0");
    put("dev/input/" + event, "");
  }
  // These lines are from a 64-bit kernel. BTN_SOUTH and its neighbours are in the fifth word.
  void plug_pad(const std::string& event) {
    plug(event, "Pad", "7cdb000000000000 0 0 0 0", "3003f");
  }
  void plug_mouse(const std::string& event) { plug(event, "SpaceMouse", "3 0 0 0 0", "3f"); }
  std::string choice(std::string_view kind, const std::string& name = "") {
    try {
      return input_node({root, {}}, kind, name);
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  test::TemporaryFolder folder;
  std::filesystem::path root = folder / "machine";
};

TEST_F(Nodes, TheOnlyOneOfAKindIsFound) {
  plug("event0", "Keyboard", "10000 7 ff9f207ac14057ff febeffdfffefffff fffffffffffffffe", "0");
  plug_pad("event10");
  plug_mouse("event9");
  EXPECT_EQ(choice("gamepad"), "/dev/input/event10");
  EXPECT_EQ(choice("spacemouse"), "/dev/input/event9");
  EXPECT_EQ(choice("gamepad", "event3"), "/dev/input/event3");
  EXPECT_EQ(choice("gamepad", "/dev/input/by-id/pad"), "/dev/input/by-id/pad");
}

TEST_F(Nodes, NoneAndSeveralAreSaid) {
  EXPECT_THAT(choice("gamepad"),
              AllOf(HasSubstr("no gamepad is plugged in"), HasSubstr("gamepad:event5")));
  plug_pad("event10");
  plug_pad("event9");
  EXPECT_THAT(choice("gamepad"), HasSubstr("gamepad:event9 (Pad), gamepad:event10 (Pad)"));
}

TEST_F(Nodes, TheDoctorKnowsThem) {
  plug_mouse("event9");
  plug_pad("event10");
  put("proc/81/comm", "Xorg");
  std::filesystem::create_directories(root / "proc/81/fd");
  std::filesystem::create_symlink("/dev/input/event10", root / "proc/81/fd/5");
  const auto seen = [&](bool may) {
    return text(scan_usb({root, [may](const std::filesystem::path&) { return may; }}));
  };
  EXPECT_THAT(seen(true),
              AllOf(HasSubstr("3D mouse, \"SpaceMouse\" (256f:c635), /dev/input/event9"),
                    HasSubstr("--device spacemouse"), HasSubstr("--device gamepad"),
                    Not(HasSubstr("problem"))));
  EXPECT_THAT(seen(false),
              HasSubstr("KERNEL==\"event*\", SUBSYSTEM==\"input\", ATTRS{id/vendor}==\"256f\", "
                        "ATTRS{id/product}==\"c635\", TAG+=\"uaccess\""));
  put("proc/82/comm", "spacenavd");
  std::filesystem::create_directories(root / "proc/82/fd");
  std::filesystem::create_symlink("/dev/input/event9", root / "proc/82/fd/5");
  EXPECT_THAT(seen(true), AllOf(HasSubstr("held by spacenavd (process 82)"),
                                HasSubstr("systemctl stop spacenavd")));
}

TEST_F(Nodes, TheDriverSaysTheSameRule) {
  plug_mouse("event9");
  EXPECT_THAT(input_node_remedy({root, {}}, "/dev/input/event9"),
              HasSubstr("ATTRS{id/product}==\"c635\", TAG+=\"uaccess\""));
}

TEST_F(Nodes, NonsenseInTheTreeIsNoDevice) {
  plug("event4", "Odd", "not hexadecimal", "3f");
  plug("event", "Odd", "3 0 0 0 0", "3f");
  plug("mouse0", "Odd", "3 0 0 0 0", "3f");
  EXPECT_THAT(choice("spacemouse"), HasSubstr("no spacemouse is plugged in"));
}

}  // namespace
}  // namespace feltwire::input_node_test
