// Runs each scene that comes with feltwire, with the client's default options.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "core/base/csv.hpp"
#include "core/base/pending_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/program.hpp"

namespace feltwire::shipped_scenes_test {
namespace {

/// Finds all scenes of the folder and its subfolders, including new ones.
std::vector<std::filesystem::path> shipped() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(FELTWIRE_SOURCE_DIR "/scenes"))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class ShippedScene : public ::testing::TestWithParam<std::filesystem::path> {};

struct PressResult {
  double peak = 0.0;   // [N] largest held force
  double share = 0.0;  // share of the scene's command, limited by the device
};

PressResult felt_in(const std::string& record) {
  const double most = builtin_device("simulated").max_force;
  std::ifstream rows(record);
  CsvReader reader(rows, record, {"ex", "ey", "ez", "fx", "fy", "fz", "rx", "ry", "rz"});
  PressResult felt;
  double wanted = 0.0, given = 0.0;
  for (std::array<double, 9> row{}; reader.next(row);) {
    const Vec3 commanded(row[0] + row[3], row[1] + row[4], row[2] + row[5]);
    const double held = Vec3(row[6], row[7], row[8]).norm();
    wanted += std::min(most, commanded.norm());
    given += held;
    felt.peak = std::max(felt.peak, held);
  }
  if (wanted > 0.0) felt.share = given / wanted;
  return felt;
}

TEST_P(ShippedScene, IsFelt) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "too slow there for a force in time";
#endif
  constexpr double kLeastPeak = 0.5;  // [N]
  const testing::TemporaryFolder folder;
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(GetParam()));
  const std::string name = scenes.front().name();
  // Half of the bound's stiffness limit (2 b/T) relative to the scene's stiffest spring.
  const DeviceSpec& device = builtin_device("simulated");
  const double shown = 2.0 * device.damping.least() / SessionParameters{}.servo_period;
  const double least_share = 0.5 * std::min(1.0, shown / scenes.front().requirements().stiffness);
  Server server(testing::any_ports(), std::move(scenes), test::security());
  const ServerAccess access = test::access(server.control_port());
  const std::string token = folder / "token", record = folder / "record.csv";
  replace_file(token, test::admin_token().text.text(), kPrivate);
  // On a busy machine late answers reduce the force. The best of several runs therefore counts.
  PressResult best;
  for (int run = 0; run < 5 && (best.peak < kLeastPeak || best.share < least_share); ++run) {
    const test::Outcome outcome =
        test::Program(FELTWIRE_CLIENT_PROGRAM,
                      {"--connect", to_string(access.endpoint), "--scene", name, "--token-file",
                       token, "--fingerprint", to_string(server.fingerprint()), "--duration", "3",
                       "--record", record})
            .finish();
    if (outcome.stalled()) continue;
    ASSERT_EQ(outcome.status, 0) << outcome.error;
    const PressResult felt = felt_in(record);
    best = {std::max(best.peak, felt.peak), std::max(best.share, felt.share)};
  }
  EXPECT_GE(best.peak, kLeastPeak);
  EXPECT_GE(best.share, least_share);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, ::testing::ValuesIn(shipped()),
                         [](const auto& scene) { return scene.param.stem().string(); });

}  // namespace
}  // namespace feltwire::shipped_scenes_test
