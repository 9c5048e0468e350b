// The functions of feltwire.h for a recording of a hand.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/c_api/c_call.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/hand_opening.hpp"
#include "client/c_api/hand_recorder.hpp"

/// The handle of a program.
struct fw_recorder : feltwire::Owned<feltwire::HandRecorder> {};

namespace feltwire {
namespace {

fw_recorder_options usual_recorder() noexcept {
  fw_recorder_options options{};
  options.struct_size = sizeof options;
  return options;
}

/// Throws std::invalid_argument that names a wrong field, and std::runtime_error if a file is
/// there that may not be replaced.
RecordingTarget target_of(const fw_recorder_options& options) {
  constexpr int kMostFiles = 9999;
  const std::string name = "recorder_options.";
  if (options.file == nullptr) throw std::invalid_argument(name + "file is null");
  RecordingTarget target{.file = options.file, .option = "recorder_options.file"};
  if (!is_mcap(target.file))
    throw std::invalid_argument(name + "file must end in .mcap, is " + target.file.string());
  if (!(options.mebibytes == 0.0 || options.mebibytes >= 1.0))
    throw std::invalid_argument(name + "mebibytes must be 0, or 1 MiB or more");
  if (!(options.seconds == 0.0 || options.seconds >= 1.0))
    throw std::invalid_argument(name + "seconds must be 0, or 1 s or more");
  if (options.mebibytes > 0.0) target.limits.mebibytes = options.mebibytes;
  if (options.seconds > 0.0) target.limits.seconds = options.seconds;
  const int files = target.limits.any() ? kMostFiles : 1;
  for (int number = 1; options.replace == 0 && number <= files; ++number)
    if (const auto file = numbered(target, number); std::filesystem::exists(file))
      throw std::runtime_error("there is a file " + file.string() + "; choose another path in " +
                               name + "file, or set " + name + "replace");
  return target;
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

void fw_recorder_options_default(fw_recorder_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_recorder(), options, struct_size);
}

std::int32_t fw_recorder_open(fw_hand* hand, const fw_recorder_options* options,
                              fw_recorder** recorder) {
  if (!is_open(hand)) return not_open("hand");
  return open_handle(recorder, "recorder", [&] {
    return hand->object->record(
        target_of(read_struct(options, usual_recorder(), "recorder_options")));
  });
}

std::int32_t fw_recorder_mark(fw_recorder* recorder, const char* text) {
  if (!is_open(recorder)) return not_open("recorder");
  if (text == nullptr) return fail(FW_ERROR_ARGUMENT, "text is null");
  return guarded([&] {
    recorder->object->mark(text_of(text, "text"));
    return FW_OK;
  });
}

std::int32_t fw_recorder_state(const fw_recorder* recorder, fw_recording_state* state,
                               std::uint32_t struct_size) {
  if (!is_open(recorder)) return not_open("recorder");
  if (state == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "state is null, or struct_size is not its size");
  fw_recording_state now{};
  now.ticks = recorder->object->ticks();
  now.lost = recorder->object->lost();
  now.failed = recorder->object->failed() ? 1 : 0;
  write_struct(now, state, struct_size);
  return FW_OK;
}

std::int32_t fw_recorder_close(fw_recorder* recorder) {
  if (recorder == nullptr) return FW_OK;
  if (!is_open(recorder)) return not_open("recorder");
  closes(recorder->object.get());
  const std::string error = recorder->object->end();
  delete recorder;
  return error.empty() ? FW_OK : fail(FW_ERROR_DEVICE, error.c_str());
}
