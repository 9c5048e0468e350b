// In this run the hand gets more energy than the device dissipated. The run must report this debt.
// The next run with the device must begin with the debt.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "client/run/run_client.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::debt_run_test {
namespace {

using testing::Loopback;
using testing::TemporaryFolder;
using testing::text_of;

/// Moves up slowly. Reports its full force as held from tick 50 to tick 150.
class Overdraws final : public Device {
 public:
  explicit Overdraws(bool overdraws) : overdraws_(overdraws) { spec_.name = "overdraws"; }
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    ++reads_;
    DeviceReading reading;
    reading.pose.position.z() = 0.01 + (overdraws_ ? 1e-4 * reads_ : 0.0);
    constexpr int kFrom = 50, kTo = 150;
    if (overdraws_ && reads_ > kFrom && reads_ < kTo)
      reading.held = Command{.elastic = Vec3(0, 0, spec_.max_force)};
    return reading;
  }
  Command write(const Command& on_hand) noexcept override { return on_hand; }
  void release() noexcept override {}

 private:
  bool overdraws_;
  int reads_ = 0;
  DeviceSpec spec_ = builtin_device("simulated");
};

nlohmann::json report_of(const std::filesystem::path& file) {
  return nlohmann::json::parse(text_of(file));
}

TEST_F(Loopback, ADebtEndsTheForceAndTheRunSaysSoAndTheNextOneOwesIt) {
  const TemporaryFolder folder;
  RunOptions options;
  options.server = endpoint;
  options.scene = "floor";
  options.device_kind = "one of this test";
  options.duration = 0.3;
  options.parameters.hold_time = 1.0;  // [s] longer than a busy machine delays a thread
  options.hold.let_go_after = options.parameters.hold_time;
  options.files.report = folder / "report.json";
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_client(std::make_unique<Overdraws>(true), options), 1);
  const std::string told = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(told.find("the force was ended: the hand got"), std::string::npos) << told;
  nlohmann::json report = report_of(*options.files.report);
  ASSERT_FALSE(report["debt_fault"].is_null());
  EXPECT_GT(report["debt_fault"]["debt_j"], 3e-6);
  EXPECT_GT(report["no_force"]["samples"]["overdrawn"], 0);
  EXPECT_LT(report["account"]["balance_j"], 0.0);

  EXPECT_EQ(run_client(std::make_unique<Overdraws>(false), options), 0);
  report = report_of(*options.files.report);
  EXPECT_TRUE(report["debt_fault"].is_null());
  EXPECT_LT(report["account"]["balance_j"], 0.0) << "a device that stands still burns nothing";

  options.device_kind = "another";
  EXPECT_EQ(run_client(std::make_unique<Overdraws>(false), options), 0);
  EXPECT_EQ(report_of(*options.files.report)["account"]["balance_j"], 0.0);
}

}  // namespace
}  // namespace feltwire::debt_run_test
