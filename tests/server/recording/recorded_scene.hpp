#pragma once
// A recorded scene with hands and a simulated clock; its files are in a temporary folder.

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/recording/event_message.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/recording/scene_recording.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/recording/recordings.hpp"
#include "tests/server/make.hpp"
#include "tests/server/sample_exchange.hpp"

namespace feltwire::test {

inline std::filesystem::path repository_scene(const std::string& name) {
  return std::filesystem::path(FELTWIRE_SOURCE_DIR) / "scenes" / name;
}

/// A server with a scene, without its threads.
struct RecordedScene {
  explicit RecordedScene(const std::filesystem::path& scene_file, std::size_t log_room = 1 << 20,
                         RecordingLimits limits = {})
      : file(folder / "scene.mcap"),
        exchange(load_scene_and_keep(scene_file), 8, {.sample_rate = 1e6}),
        log(log_room),
        recording(std::make_unique<SceneRecording>(
            SceneRecordingTarget{file, limits, about_recording(exchange.scene.name())},
            exchange.scene.files().get(), 0)) {
    exchange.sessions.log_to(&log);
  }

  void join(std::uint64_t id, const control::JoinRequest& request = join_request()) {
    const auto answer = exchange.sessions.answer(request, id, keys(id), exchange.now);
    if (!std::holds_alternative<control::JoinAccepted>(answer))
      throw std::runtime_error(std::get<control::Refused>(answer).reason);
    ids.push_back(id);
  }
  /// Runs some milliseconds with a sample of each hand in each.
  void run(int milliseconds) {
    for (int n = 0; n < milliseconds; ++n) {
      exchange.now += std::chrono::milliseconds(1);
      for (const std::uint64_t id : ids) {
        Sample sample = hand(exchange.index[id] + 1 + (id >> 3));
        sample.pose.position += exchange.scene.start().position;
        exchange.send(id, sample, false);
      }
      if (n % 100 == 0) exchange.sessions.check(exchange.now);
      if (n % 10 == 0) write();
    }
    write();
  }
  void write() {
    while (const auto event = log.take())
      recording->add(
          *event, event->kind == EventKind::reload ? log.files_of(event->number).get() : nullptr);
    recording->flush();
  }
  /// Finishes the recording; returns its only or first file.
  std::filesystem::path finish() {
    write();
    recording->finish();
    keep_recordings("server", file.parent_path());
    return file;
  }

  testing::TemporaryFolder folder;
  std::filesystem::path file;
  SampleExchange exchange;
  std::vector<std::uint64_t> ids;
  EventLog log;
  std::unique_ptr<SceneRecording> recording;
};

/// Rewrites a file. `change` may alter an event or drop it by returning false. `keep` selects the
/// attachments.
inline void rewrite(const std::filesystem::path& file,
                    const std::function<bool(RecordedEvent& event, std::string& payload)>& change,
                    const std::function<bool(const mcap::Attachment&)>& keep = {}) {
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  struct KeptEvent {
    std::uint64_t time;
    std::string data;
  };
  std::vector<KeptEvent> events;
  while (const auto message = reader.next()) {
    if (reader.channels().at(message->channel).topic != "/scene/events") continue;
    RecordedEvent event = *read_event(message->data);
    std::string payload(event.payload);
    if (!change(event, payload)) continue;
    event.payload = payload;
    events.push_back({message->log_time, {}});
    append(events.back().data, event);
  }
  mcap::Writer writer;
  for (const auto& metadata : reader.metadata()) writer.add(metadata);
  for (const auto& attachment : reader.attachments())
    if (!keep || keep(attachment)) writer.attach(attachment);
  const auto channel =
      writer.add(mcap::Channel{writer.add(event_schema()), "/scene/events", "protobuf"});
  for (const KeptEvent& event : events) writer.write(channel, event.time, event.data);
  writer.finish();
  std::ofstream(file, std::ios::binary) << writer.take();
}

}  // namespace feltwire::test
