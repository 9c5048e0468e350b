// Tests files without a valid arm. The error must name the file, the missing part and the remedy.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "core/base/file_error.hpp"
#include "tests/client/simulated_robots/arm_support.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::arm_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ArmFile : public testing::Test {
 protected:
  /// Returns the error for an arm.xml in which `to` replaces each `from`.
  std::string error_of(const std::string& from, const std::string& to) {
    std::ifstream in(scene("arm"));
    std::stringstream read;
    read << in.rdbuf();
    std::string text = read.str();
    EXPECT_NE(text.find(from), std::string::npos) << from;
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    const auto file = folder_ / "arm.xml";
    std::ofstream(file) << text;
    ArmConfig config;
    config.file = file;
    try {
      const Arm arm(config);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }

  test::TemporaryFolder folder_;
};

TEST_F(ArmFile, NamesWhatIsMissing) {
  EXPECT_THAT(error_of("site name=\"tool\"", "site name=\"tip\""),
              AllOf(HasSubstr("arm.xml: has no site 'tool'; add <site")));
  EXPECT_THAT(error_of("joint3", "elbow"),
              HasSubstr("has no joint 'joint3'; an arm has the hinge joints joint1 to joint7"));
  EXPECT_THAT(error_of("<force name=\"wrist_force\" site=\"wrist\"/>", ""),
              HasSubstr("has no sensor 'wrist_force'; add <force name=\"wrist_force\""));
  EXPECT_THAT(error_of("<motor joint=\"joint2\" ctrllimited=\"true\" ctrlrange=\"-87 87\"/>", ""),
              HasSubstr("joint 'joint2' has no motor; write <motor joint=\"joint2\""));
  EXPECT_THAT(error_of("name=\"home\"", "name=\"rest\""),
              HasSubstr("has no <numeric name=\"home\"> of seven angles"));
}

TEST_F(ArmFile, NamesWhatIsWrong) {
  EXPECT_THAT(error_of("data=\"0 -0.785398", "data=\"3 -0.785398"),
              HasSubstr("home: angle 1 is 3.000000 rad, outside of the joint's range"));
  EXPECT_THAT(error_of("<accelerometer name=\"tool_acceleration\" site=\"balance\"/>",
                       "<accelerometer name=\"tool_acceleration\" site=\"wrist\"/>"),
              HasSubstr("at another site; write <accelerometer"));
  EXPECT_THAT(error_of("name=\"joint4\" range", "name=\"joint4\" limited=\"false\" range"),
              HasSubstr("joint 'joint4' has no limits"));
  EXPECT_THAT(error_of("timestep=\"0.0005\"", "timestep=\"0.0007\""),
              HasSubstr("does not divide the servo period"));
  EXPECT_THAT(error_of("timestep=\"0.0005\"", "timestep=\"0.0005\" integrator=\"RK4\""),
              HasSubstr("integrator is not Euler"));
  EXPECT_THAT(error_of("</worldbody>", "</worldbdy>"), HasSubstr("arm.xml: "));
}

TEST(ArmFileMissing, IsNamed) {
  ArmConfig config;
  config.file = "/proc/nowhere/arm.xml";
  try {
    const Arm arm(config);
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("/proc/nowhere/arm.xml"));
  }
}

TEST(ArmNumbers, AreChecked) {
  ArmConfig config = config_of("arm");
  config.stiffness = 0.0;
  try {
    const Arm arm(config);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("stiffness: is 0;"), HasSubstr("above 0")));
  }
}

}  // namespace
}  // namespace feltwire::arm_test
