// A recording that a program of the C interface starts and stops while its hand goes on.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "client/c_api/feltwire.h"
#include "core/recording/mcap_reader.hpp"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RecorderApi : public ::testing::Test {
 protected:
  RecorderApi() {
    const fw_hand_options options = server_.hand_options();
    EXPECT_EQ(fw_hand_open(&options, &hand_), FW_OK) << fw_last_error();
  }
  ~RecorderApi() override { EXPECT_EQ(fw_hand_close(hand_), FW_OK) << fw_last_error(); }

  std::string path(const char* name) const { return (server_.folder / name).string(); }
  std::int32_t open(const std::string& file, fw_recorder** recorder, bool replace = false) const {
    fw_recorder_options options;
    fw_recorder_options_default(&options, sizeof options);
    options.file = file.c_str();
    options.replace = replace ? 1 : 0;
    return fw_recorder_open(hand_, &options, recorder);
  }
  static fw_recording_state state_of(const fw_recorder* recorder) {
    fw_recording_state state{};
    EXPECT_EQ(fw_recorder_state(recorder, &state, sizeof state), FW_OK);
    return state;
  }

  ApiServer server_;
  fw_hand* hand_ = nullptr;
};

TEST_F(RecorderApi, HasEveryTickAndEveryMark) {
  const std::string file = path("hand.mcap");
  fw_recorder *recorder = nullptr, *second = nullptr;
  ASSERT_EQ(open(file, &recorder), FW_OK) << fw_last_error();
  EXPECT_EQ(open(path("other.mcap"), &second), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("recorded already"));
  EXPECT_FALSE(std::filesystem::exists(path("other.mcap")));
  test::eventually("ticks", [&] { return state_of(recorder).ticks >= 300; });
  EXPECT_EQ(fw_recorder_mark(recorder, "half"), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_recorder_mark(recorder, "caf\xe9"), FW_ERROR_ARGUMENT) << "Latin-1";
  EXPECT_STREQ(fw_last_error(), "text is not text in UTF-8");
  EXPECT_EQ(fw_recorder_mark(nullptr, "half"), FW_ERROR_ARGUMENT);
  EXPECT_STREQ(fw_last_error(), "the recorder is null, or another process opened it");
  test::eventually("ticks", [&] { return state_of(recorder).ticks >= 600; });
  EXPECT_EQ(state_of(recorder).lost, 0u);
  ASSERT_EQ(fw_recorder_close(recorder), FW_OK) << fw_last_error();

  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file);
  std::uint64_t samples = 0;
  while (const auto message = reader.next())
    samples += reader.channels().at(message->channel).topic == "/hand/sample" ? 1 : 0;
  EXPECT_FALSE(reader.cut_at());
  EXPECT_GE(samples, 600u);
  std::vector<std::string> marks;
  for (const mcap::Metadata& record : reader.metadata())
    if (record.name == "mark") marks.push_back(record.values.at("text"));
  EXPECT_THAT(marks, ElementsAre("half"));
  ASSERT_EQ(open(path("next.mcap"), &recorder), FW_OK) << "another one of the same hand";
  EXPECT_EQ(fw_recorder_close(recorder), FW_OK) << fw_last_error();
}

TEST_F(RecorderApi, AFileThatIsThereIsReplacedOnlyIfTheProgramSaysSo) {
  const std::string file = path("hand.mcap");
  fw_recorder* recorder = nullptr;
  for (const bool replace : {false, true}) {
    ASSERT_EQ(open(file, &recorder, replace), FW_OK) << fw_last_error();
    EXPECT_EQ(fw_recorder_close(recorder), FW_OK) << fw_last_error();
    EXPECT_EQ(open(file, &recorder), FW_ERROR_DEVICE);
    EXPECT_THAT(fw_last_error(), HasSubstr("there is a file " + file));
  }
  EXPECT_EQ(open(path("hand.csv"), &recorder), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("must end in .mcap"));
  EXPECT_EQ(open(path("no/hand.mcap"), &recorder), FW_ERROR_DEVICE);
  EXPECT_THAT(fw_last_error(), HasSubstr("recorder_options.file"));
  EXPECT_EQ(recorder, nullptr);
}

TEST_F(RecorderApi, AFullDiskIsToldAndTheHandGoesOn) {
  const std::string file = path("full.mcap");
  std::filesystem::create_symlink("/dev/full", file);
  fw_recorder* recorder = nullptr;
  // The first write is that of the file's beginning.
  EXPECT_EQ(open(file, &recorder, true), FW_ERROR_DEVICE);
  EXPECT_THAT(fw_last_error(), HasSubstr("No space left"));
  EXPECT_EQ(recorder, nullptr);
  fw_tick tick{};
  EXPECT_GE(fw_hand_latest(hand_, &tick, sizeof tick), FW_OK);
}

TEST_F(RecorderApi, TheHandMayBeClosedFirst) {
  fw_recorder* recorder = nullptr;
  ASSERT_EQ(open(path("hand.mcap"), &recorder), FW_OK) << fw_last_error();
  test::eventually("ticks", [&] { return state_of(recorder).ticks > 10; });
  ASSERT_EQ(fw_hand_close(hand_), FW_OK) << fw_last_error();
  hand_ = nullptr;
  EXPECT_EQ(fw_recorder_mark(recorder, "the end"), FW_OK) << fw_last_error();
  EXPECT_EQ(fw_recorder_close(recorder), FW_OK) << fw_last_error();
}

}  // namespace
}  // namespace feltwire::c_api_test
