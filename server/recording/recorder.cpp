#include "server/recording/recorder.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "protocol/net/busy_poll.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{10};
// [bytes] Memory of a scene's event log. The samples of 16 hands at 1 kHz fill it in 3 s.
constexpr std::size_t kLogRoom = std::size_t{8} << 20;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_';
}

}  // namespace

std::string name_in_files(const std::string& scene, std::size_t place) {
  if (std::ranges::all_of(scene, is_plain)) return scene;
  std::string name = scene;
  std::ranges::replace_if(
      name, [](char c) { return !is_plain(c); }, '_');
  return name + '-' + std::to_string(place + 1);
}

std::filesystem::path recording_file(const std::filesystem::path& file,
                                     const std::vector<std::string>& scenes, std::size_t place) {
  if (scenes.size() == 1) return file;
  return file.parent_path() / (file.stem().string() + '-' + name_in_files(scenes[place], place) +
                               file.extension().string());
}

Recorder::OneScene::OneScene(std::string scene, std::shared_ptr<const CapturedFiles> kept)
    : name(std::move(scene)), files(std::move(kept)), log(kLogRoom) {}

Recorder::Recorder(const RecorderOptions& options, const std::vector<Scene>& scenes) {
  std::vector<std::string> names;
  names.reserve(scenes.size());
  for (const Scene& scene : scenes) names.push_back(scene.name());
  const std::int64_t offset = clock_offset();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    OneScene& scene =
        *scenes_.emplace_back(std::make_unique<OneScene>(names[i], scenes[i].files()));
    if (!options.file.empty())
      scene.recording = std::make_unique<SceneRecording>(
          SceneRecordingTarget{recording_file(options.file, names, i), options.limits,
                               about_recording(names[i]), "--record",
                               options.describe ? options.describe(scenes[i]) : SceneToShow{}},
          scene.files.get(), offset);
    if (!options.flight_folder.empty())
      scene.flight = std::make_unique<FlightRecorder>(
          options.flight_folder, name_in_files(names[i], i), about_recording(names[i]), offset);
    if (!options.asked.folder.empty()) {
      AskedRecordingOptions asked = options.asked;
      asked.shown = [&scene, describe = options.describe] {
        if (!describe || scene.present == nullptr) return SceneToShow{};
        return describe(*scene.present->current_scene().scene);
      };
      scene.asked = std::make_unique<AskedRecording>(std::move(asked), names[i],
                                                     name_in_files(names[i], i), offset);
    }
  }
}

Recorder::~Recorder() { stop(); }

void Recorder::start() {
  thread_ = std::thread([this] { run(); });
}

void Recorder::stop() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Recorder::run() {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kBetweenLooks, [this] { return stopping_; })) {
    lock.unlock();
    look();
    lock.lock();
  }
  lock.unlock();
  look();
  for (const auto& scene : scenes_) {
    write(*scene, [](SceneRecording& recording) { recording.finish(); });
    if (scene->flight != nullptr) scene->flight->write_if_due(false, kForever);
    if (scene->asked != nullptr) scene->asked->finish();
  }
}

/// Calls `action` with the scene's recording. If this throws, logs the error and closes the
/// recording.
template <class Action>
void Recorder::write(OneScene& scene, Action action) {
  if (scene.recording == nullptr) return;
  try {
    action(*scene.recording);
  } catch (const std::exception& error) {
    scene.recording.reset();
    spdlog::error("scene {}: {}; the server goes on", scene.name, error.what());
  }
}

void Recorder::ask_for_flight_record(std::size_t scene, FlightWritten written) {
  const std::lock_guard lock(mutex_);
  scenes_[scene]->wanted.push_back(std::move(written));
}

void Recorder::ask_for_flight_records() {
  for (std::size_t i = 0; i < scenes_.size(); ++i) ask_for_flight_record(i, [](const auto&) {});
}

void Recorder::look_after_flights(OneScene& scene) {
  std::vector<FlightWritten> wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted.swap(scene.wanted);
  }
  const auto file = scene.flight->write_if_due(!wanted.empty(), monotonic_now());
  for (const FlightWritten& written : wanted) written(file);
}

void Recorder::record(std::size_t scene, control::RecordingAction action, Recorded done) {
  const std::lock_guard lock(mutex_);
  scenes_[scene]->actions.emplace_back(action, std::move(done));
}

void Recorder::look_after_asked(OneScene& scene) {
  std::vector<std::pair<control::RecordingAction, Recorded>> actions;
  {
    const std::lock_guard lock(mutex_);
    actions.swap(scene.actions);
  }
  const Nanoseconds now = monotonic_now();
  scene.asked->look_after(now);
  for (const auto& [action, done] : actions) done(scene.asked->act(action, now));
}

void Recorder::look() {
  for (const auto& scene : scenes_) look(*scene);
}

void Recorder::look(OneScene& scene) {
  while (const auto event = scene.log.take()) {
    const auto files =
        event->kind == EventKind::reload ? scene.log.files_of(event->number) : nullptr;
    write(scene, [&](SceneRecording& recording) { recording.add(*event, files.get()); });
    if (scene.flight != nullptr) scene.flight->add(*event);
    if (scene.asked != nullptr) scene.asked->add(*event);
  }
  if (scene.pictures != nullptr && scene.pictures->take(scene.picture)) {
    write(scene, [&](SceneRecording& recording) { recording.see(scene.picture); });
    if (scene.asked != nullptr) scene.asked->see(scene.picture);
  }
  write(scene, [](SceneRecording& recording) { recording.flush(); });
  if (scene.flight != nullptr) look_after_flights(scene);
  if (scene.asked != nullptr) look_after_asked(scene);
  if (const std::uint64_t lost = scene.log.lost(); lost > scene.told_lost / 2 * 3) {
    scene.told_lost = lost;
    spdlog::warn(
        "scene {}: the recorder cannot keep up: {} events are missing so far, and no replay can be "
        "complete; use a faster disk, or record fewer hands",
        scene.name, lost);
  }
}

}  // namespace feltwire
