#include "server/recording/asked_recording.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "core/recording/dated_files.hpp"

namespace feltwire {

using control::RecordingAction;
using control::RecordingEnd;
using control::RefusalCode;
using control::Refused;
namespace {

constexpr Nanoseconds kBetweenRoomLooks = std::chrono::seconds(1);
constexpr DatedKind kRecordings{.begin = "recording-",
                                .option = "--recordings",
                                .what = "a recording",
                                .most_files = AskedRecordingOptions::kMostFiles,
                                .most_bytes = AskedRecordingOptions::kMostBytes};

}  // namespace

const char* text(RecordingEnd why) {
  switch (why) {
    case RecordingEnd::none:
    case RecordingEnd::asked:
      break;
    case RecordingEnd::size:
      return "its largest size is reached";
    case RecordingEnd::time:
      return "its longest time is reached";
    case RecordingEnd::room:
      return "the disk has too little room";
    case RecordingEnd::failed:
      return "the file could not be written";
  }
  return "";
}

std::optional<std::uintmax_t> free_room(const std::filesystem::path& folder) {
  std::error_code unknown;
  const auto space = std::filesystem::space(folder, unknown);
  return unknown ? std::nullopt : std::optional(space.available);
}

AskedRecording::AskedRecording(AskedRecordingOptions options, const std::string& scene,
                               std::string name, std::int64_t offset)
    : options_(std::move(options)), scene_(scene), name_(std::move(name)), offset_(offset) {
  make_dated_folder(kRecordings, options_.folder);
}

std::variant<control::SceneRecordings, Refused> AskedRecording::act(RecordingAction action,
                                                                    Nanoseconds now) {
  if (action == RecordingAction::start) {
    if (auto refused = start(now)) return *std::move(refused);
  } else if (action == RecordingAction::stop) {
    if (recording_ == nullptr)
      return Refused{RefusalCode::failed, "no recording of the scene runs, so none can be stopped"};
    seconds_ = seconds(now - started_);
    end(RecordingEnd::asked);
  }
  return state(now);
}

std::optional<Refused> AskedRecording::start(Nanoseconds now) {
  if (recording_ != nullptr)
    return Refused{RefusalCode::failed, "a recording of the scene runs already; stop it first"};
  try {
    if (!has_room())
      return Refused{RefusalCode::failed,
                     "the disk of " + options_.folder.string() +
                         " has too little room for a recording; remove files there"};
    file_ = next_dated_file(kRecordings, options_.folder, name_,
                            static_cast<std::uint64_t>(now.count() + offset_));
    recording_ = std::make_unique<SceneRecording>(
        SceneRecordingTarget{file_,
                             {},
                             about_recording(scene_),
                             kRecordings.option,
                             options_.shown ? options_.shown() : SceneToShow{}},
        nullptr, offset_);
  } catch (const std::exception& error) {
    spdlog::error("scene {}: no recording: {}", scene_, error.what());
    return Refused{RefusalCode::failed,
                   "the recording could not be started; the server's log says why"};
  }
  started_ = looked_at_room_ = now;
  seconds_ = 0.0;
  bytes_ = recording_->bytes();
  ended_ = RecordingEnd::none;
  spdlog::info("scene {}: records to {}", scene_, file_.string());
  return std::nullopt;
}

/// Closes the file, so that it has its index and is complete.
void AskedRecording::end(RecordingEnd why) {
  ended_ = why;
  try {
    recording_->finish();
    bytes_ = recording_->bytes();
  } catch (const std::exception& error) {
    ended_ = RecordingEnd::failed;
    spdlog::error("scene {}: {}; the server goes on", scene_, error.what());
  }
  recording_.reset();
  const std::string reason = text(ended_);
  spdlog::info("scene {}: recorded {:.1f} s to {}{}", scene_, seconds_, file_.string(),
               reason.empty() ? "" : "; " + reason);
}

/// Calls `action` with the recording that runs. If this throws, the recording ends.
template <class Action>
void AskedRecording::write(Action action) {
  if (recording_ == nullptr) return;
  try {
    action(*recording_);
    bytes_ = recording_->bytes();
  } catch (const std::exception& error) {
    recording_.reset();
    ended_ = RecordingEnd::failed;
    spdlog::error("scene {}: {}; the recording ends, and the server goes on", scene_, error.what());
  }
}

void AskedRecording::add(const SceneEvent& event) {
  write([&](SceneRecording& recording) { recording.add(event); });
}

void AskedRecording::see(const Picture& picture) {
  write([&](SceneRecording& recording) { recording.see(picture); });
}

void AskedRecording::look_after(Nanoseconds now) {
  write([](SceneRecording& recording) { recording.flush(); });
  if (recording_ == nullptr) return;
  const Nanoseconds lasts = now - started_;
  seconds_ = seconds(lasts);
  if (options_.limits.reached(bytes_, 0)) return end(RecordingEnd::size);
  if (options_.limits.reached(0, static_cast<std::uint64_t>(lasts.count())))
    return end(RecordingEnd::time);
  if (now - looked_at_room_ < kBetweenRoomLooks) return;
  looked_at_room_ = now;
  if (!has_room()) end(RecordingEnd::room);
}

void AskedRecording::finish() {
  if (recording_ != nullptr) end(RecordingEnd::asked);
}

/// Returns whether the disk keeps its least room. A disk that does not say counts as one that does:
/// a write that fails ends the recording, too.
bool AskedRecording::has_room() const {
  const auto room = options_.room(options_.folder);
  return !room || *room >= options_.least_room;
}

control::SceneRecordings AskedRecording::state(Nanoseconds now) const {
  control::SceneRecordings told;
  told.scene = scene_;
  told.folder = options_.folder.string();
  told.seconds = seconds_;
  told.bytes = bytes_;
  told.ended = ended_;
  if (recording_ != nullptr) {
    told.running = file_.filename().string();
    told.seconds = seconds(now - started_);
  }
  std::vector<DatedFile> files = dated_files(kRecordings, options_.folder, name_);
  std::ranges::reverse(files);
  for (DatedFile& file : files) {
    if (file.name == told.running) continue;
    if (told.kept.size() == control::kMaxKept) break;
    told.kept.push_back({std::move(file.name), file.bytes});
  }
  return told;
}

}  // namespace feltwire
