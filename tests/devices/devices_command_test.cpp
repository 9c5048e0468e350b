// Tests `feltwire-client devices` on simulated machines, with substitutes for the makers'
// libraries.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/device/device_spec.hpp"
#include "tests/devices/hapi_stand_in.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::devices_command_test {
namespace {

using test::Outcome;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Restricts the search for makers' libraries to given folders.
struct DevicesCommand : ::testing::Test {
  DevicesCommand() { look_in(folder / "none", folder / "none", folder / "none"); }
  ~DevicesCommand() override {
    for (const char* name : {"FDSDK", "OH_SDK_BASE", "LD_LIBRARY_PATH"}) ::unsetenv(name);
    ::setenv("HOME", home.c_str(), 1);
  }
  void look_in(const std::string& fdsdk, const std::string& openhaptics, const std::string& usb) {
    ::setenv("HOME", (folder / "home").c_str(), 1);
    ::setenv("FDSDK", fdsdk.c_str(), 1);
    ::setenv("OH_SDK_BASE", openhaptics.c_str(), 1);
    ::setenv("LD_LIBRARY_PATH", usb.c_str(), 1);
  }
  void plug(const std::string& vendor, const std::string& product) const {
    const auto port = folder / "machine/sys/bus/usb/devices/1-1";
    std::filesystem::create_directories(port);
    for (const auto& [name, text] :
         {std::pair("idVendor", vendor), std::pair("idProduct", product),
          std::pair("busnum", std::string("1")), std::pair("devnum", std::string("4"))})
      std::ofstream(port / name) << text << "\n";
    std::filesystem::create_directories(folder / "machine/dev/bus/usb/001");
    std::ofstream(folder / "machine/dev/bus/usb/001/004");
  }
  Outcome devices() const {
    return test::Program(FELTWIRE_CLIENT_PROGRAM, {"devices", "--root", folder / "machine"})
        .finish();
  }

  std::string home = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "/";
  test::TemporaryFolder folder;
};

TEST_F(DevicesCommand, PrintsTheBuiltInSpecificationsWithTheirSources) {
  const Outcome told = test::Program(FELTWIRE_CLIENT_PROGRAM, {"devices", "--specs"}).finish();
  EXPECT_EQ(told.status, 0) << told.error;
  for (const DeviceSpec& spec : builtin_devices()) EXPECT_THAT(told.out, HasSubstr(spec.name));
  EXPECT_THAT(told.out, HasSubstr("assumption, small on purpose"));
}

TEST_F(DevicesCommand, NamesEachLibraryWithItsVersion) {
  look_in(FELTWIRE_FDSDK, FELTWIRE_OH_SDK, FELTWIRE_USB);
  const Outcome told = devices();
  EXPECT_EQ(told.status, 0) << told.error;
  EXPECT_THAT(told.out, HasSubstr("no haptic device that feltwire knows"));
  EXPECT_THAT(told.out,
              AllOf(HasSubstr("forcedimension: /"), HasSubstr("libdrd.so.3, version 3.17.5\n")));
  EXPECT_THAT(told.out, AllOf(HasSubstr("openhaptics: /"), HasSubstr("/libHD.so\n")));
  EXPECT_THAT(told.out,
              AllOf(HasSubstr("falcon: /"), HasSubstr("libusb-1.0.so.0, version 1.0.26\n")));
}

/// The output must name each searched folder, even without a file in it.
TEST_F(DevicesCommand, NamesWhatIsMissingAndWhereItLooked) {
  std::filesystem::create_directory(folder / "usb");
  std::filesystem::copy_file(FELTWIRE_EMPTY_LIBRARY, folder / "usb/libusb-1.0.so.0");
  look_in(folder / "none", folder / "none", folder / "usb");
  const Outcome told = devices();
  EXPECT_EQ(told.status, 0) << told.error;  // No connected device needs these libraries.
  EXPECT_THAT(told.out, HasSubstr("forcedimension: the maker's library cannot be used: "));
  EXPECT_THAT(told.out, HasSubstr((folder / "none/lib/release").string()));
  EXPECT_THAT(told.out, HasSubstr((folder / "home/.local/lib/libdrd.so").string()));
  EXPECT_THAT(told.out, HasSubstr("openhaptics: the maker's library cannot be used: "));
  EXPECT_THAT(told.out, HasSubstr("falcon: libusb cannot be used: "));
  EXPECT_THAT(told.out, HasSubstr("has no function libusb_init"));
}

TEST_F(DevicesCommand, ADeviceWhoseLibraryIsMissingIsAProblem) {
  plug("1451", "0402");
  const Outcome told = devices();
  EXPECT_EQ(told.status, 1) << told.error;
  EXPECT_THAT(told.out, HasSubstr("(1451:0402)"));
}

TEST_F(DevicesCommand, MeasuresTheRateOfABoard) {
  stand_in::HapiBoard board;
  const Outcome told =
      test::Program(FELTWIRE_CLIENT_PROGRAM,
                    {"devices", "--rate", "hapi:" + board.port(), "--seconds", "0.3"})
          .finish();
  EXPECT_THAT(told.out, AllOf(HasSubstr("hapi_2dof for 0.3 s"), HasSubstr("ticks a second"),
                              HasSubstr("faults")));
  EXPECT_EQ(board.force, 0.0);
}

TEST_F(DevicesCommand, WrongWordsAreRefused) {
  const Outcome told =
      test::Program(FELTWIRE_CLIENT_PROGRAM, {"devices", "--rate", "touch"}).finish();
  EXPECT_EQ(told.status, 2);
  EXPECT_THAT(told.error, HasSubstr("unknown device 'touch'"));
}

}  // namespace
}  // namespace feltwire::devices_command_test
