#include "server/recording/scene_replay.hpp"

#include <algorithm>
#include <deque>
#include <fstream>
#include <memory>

#include "core/base/file_error.hpp"
#include "core/build_info/build_info.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/recording/event_reader.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

/// Returns the session id that a hand has in the replay. It is not 0: hand numbers begin at 1.
std::uint64_t id_of(std::uint32_t hand) { return std::uint64_t{hand} << 8; }

std::string value(const mcap::Metadata& metadata, const std::string& key) {
  const auto at = metadata.values.find(key);
  return at == metadata.values.end() ? std::string() : at->second;
}

/// Replays the recorded events one by one. The sessions write a new event log, which is compared
/// with the recorded events.
class Replayer {
 public:
  Replayer(std::shared_ptr<const Scene> scene, std::shared_ptr<const Scene> given)
      : given_(std::move(given)),
        scene_(std::move(scene)),
        sessions_(*scene_, kNever, kMostSessions) {
    sessions_.log_to(&log_);
  }

  /// Replays one event. Returns how its result differs from the recorded one; nothing: they are
  /// equal. Precondition: `mcap` was read up to this event, so that it has the files of a reload.
  std::optional<std::string> take(const SceneEvent& recorded, const mcap::Reader& mcap,
                                  const std::string& file) {
    reply_ = {};
    std::optional<SceneEvent> computed = log_.take();
    if (!computed) {
      if (auto wrong = apply(recorded, mcap, file)) return wrong;
      computed = log_.take();
    }
    if (!computed)
      return std::string(
          "nothing came of it, because there is no such session or because it was "
          "refused");
    return difference(recorded, *computed);
  }
  /// Returns the payload of the reply to the last event; empty if there was no reply.
  Bytes reply() const { return reply_; }

 private:
  static constexpr Nanoseconds kNever{std::int64_t{1} << 62};
  static constexpr std::size_t kMostSessions = 4096, kLogRoom = std::size_t{1} << 20;

  std::optional<std::string> apply(const SceneEvent& event, const mcap::Reader& mcap,
                                   const std::string& file) {
    switch (event.kind) {
      case EventKind::join:
      case EventKind::parameters:
        return ask(event);
      case EventKind::samples:
        reply_ = sessions_.replay_samples(id_of(event.hand), event.payload, event.time);
        return std::nullopt;
      case EventKind::tick:
        sessions_.tick(event.time);
        return std::nullopt;
      case EventKind::end:
        sessions_.replay_end(id_of(event.hand), static_cast<SessionEnd>(event.payload[0]));
        return std::nullopt;
      case EventKind::reload:
        return reload(event, mcap, file);
      case EventKind::check:
        sessions_.check(event.time);
        return std::nullopt;
      case EventKind::change:
        return change(event);
      case EventKind::path:
        sessions_.limit_replies(id_of(event.hand), event.payload[0] | event.payload[1] << 8,
                                event.time);
        return std::nullopt;
      case EventKind::pace:
        sessions_.replay_pace(id_of(event.hand), event.payload[0], event.time);
        return std::nullopt;
      case EventKind::none:
      case EventKind::count_of_kinds:
        break;
    }
    return std::string("this version does not know how to do it again");
  }

  std::optional<std::string> ask(const SceneEvent& event) {
    std::optional<control::Message> request = control::decode(event.payload);
    if (!request) return std::string("its request cannot be read");
    const bool join = std::holds_alternative<control::JoinRequest>(*request);
    if (auto* set = std::get_if<control::SetParameters>(&*request)) {
      set->session = id_of(event.hand);
    } else if (auto* take = std::get_if<control::TakeSurfaces>(&*request)) {
      take->session = id_of(event.hand);
    } else if (!join || event.kind != EventKind::join) {
      return std::string("its request is another one");
    }
    const control::Message answer =
        sessions_.answer(*request, id_of(event.hand), SessionKeys{}, event.time);
    if (const auto* refused = std::get_if<control::Refused>(&answer))
      return "its request was refused: " + refused->reason;
    return std::nullopt;
  }

  std::optional<std::string> change(const SceneEvent& event) {
    const std::optional<control::Message> request = control::decode(event.payload);
    if (!request) return std::string("its request cannot be read");
    LiveChange wanted;
    if (const auto* material = std::get_if<control::SetMaterial>(&*request))
      wanted = material->change;
    else if (const auto* gravity = std::get_if<control::SetGravity>(&*request))
      wanted = GravityChange{gravity->gravity};
    else if (const auto* link = std::get_if<control::SetLink>(&*request))
      wanted = LinkChange{id_of(event.hand), link->link};
    else if (const auto* lead = std::get_if<control::SetLead>(&*request))
      wanted = LeadChange{id_of(event.hand), lead->share};
    else
      return std::string("its request is another one");
    ChangeOutcome outcome = sessions_.change(wanted, event.time);
    if (const auto* refused = std::get_if<control::Refused>(&outcome))
      return "its request was refused: " + refused->reason;
    if (auto& made = std::get<Changed>(outcome); made.scene != nullptr) scene_ = made.scene;
    return std::nullopt;
  }

  std::optional<std::string> reload(const SceneEvent& event, const mcap::Reader& mcap,
                                    const std::string& file);

  static std::optional<std::string> difference(const SceneEvent& recorded,
                                               const SceneEvent& computed) {
    if (recorded.kind != computed.kind || recorded.hand != computed.hand ||
        recorded.time != computed.time)
      return std::string("a ") + name(computed.kind) + " of hand " + std::to_string(computed.hand) +
             " came before it";
    if (recorded.outcome != computed.outcome)
      return std::string(computed.outcome == EventOutcome::answered
                             ? "there is a reply now, and there was none"
                             : "there is no reply now, and there was one");
    if (recorded.digest != computed.digest)
      return std::string(recorded.kind == EventKind::check ? "the moving bodies are elsewhere"
                                                           : "the reply has other bytes");
    if (!std::ranges::equal(recorded.payload, computed.payload))
      return std::string("it came into force with other values");
    return std::nullopt;
  }

  std::shared_ptr<const Scene> given_;
  std::shared_ptr<const Scene> scene_;
  EventLog log_{kLogRoom};
  SceneSessions sessions_;
  Bytes reply_;
};

/// Loads the scene that the recording has under this number. Returns null if it has no such scene.
std::shared_ptr<const Scene> kept_scene(const mcap::Reader& mcap, std::uint64_t number,
                                        const std::string& file) {
  const std::string prefix = "scene-" + std::to_string(number);
  CapturedFiles kept;
  for (const mcap::Metadata& metadata : mcap.metadata())
    if (metadata.name == prefix) kept.main = value(metadata, "main");
  for (const mcap::Attachment& attachment : mcap.attachments())
    if (attachment.name.starts_with(prefix + '/'))
      kept.files.emplace(attachment.name.substr(prefix.size() + 1), attachment.data);
  if (kept.files.empty()) return nullptr;
  try {
    return std::make_shared<const Scene>(load_kept_scene(kept));
  } catch (const std::exception& error) {
    throw FileError(file + ": its scene " + prefix + ": " + error.what() +
                    "; name the scene's file with --scene");
  }
}

std::optional<std::string> Replayer::reload(const SceneEvent& event, const mcap::Reader& mcap,
                                            const std::string& file) {
  std::shared_ptr<const Scene> next =
      given_ != nullptr ? given_ : kept_scene(mcap, event.number, file);
  if (next == nullptr) return std::string("the reloaded scene is not in the recording");
  sessions_.enter(*next, event.time);
  scene_ = std::move(next);
  return std::nullopt;
}

/// Reads the files of a recording one after the other.
class Reading {
 public:
  Reading(const std::vector<std::filesystem::path>& files, std::shared_ptr<const Scene> given,
          OnReply on_reply)
      : given_(std::move(given)), on_reply_(std::move(on_reply)) {
    result_.replayed_by = build_info("feltwire-server");
    for (const auto& file : files) {
      if (result_.difference || result_.lost > 0) break;
      read(file);
    }
    if (replayer_ == nullptr)
      throw FileError(files.back().string() + ": has no input log of a server; " + kEventRemedy);
  }
  Replay result() && { return std::move(result_); }

 private:
  void read(const std::filesystem::path& path) {
    const std::string file = path.string();
    std::ifstream in(path, std::ios::binary);
    if (!in) throw FileError(file + ": cannot be read; check the path");
    mcap::Reader mcap(in, file);
    while (const auto message = mcap.next()) {
      if (!EventReader::is_event(mcap, *message)) continue;
      const SceneEvent event = events_.read(*message, file);
      if (!take(event, mcap, file)) return;
      if (on_reply_ && !replayer_->reply().empty())
        on_reply_(event, message->log_time, replayer_->reply());
    }
    result_.cut_at = mcap.cut_at();
  }

  /// Replays an event. Returns false if the replay ends here: an event is missing before this one,
  /// or the result differs.
  bool take(const SceneEvent& event, const mcap::Reader& mcap, const std::string& file) {
    if (replayer_ == nullptr) begin(event, mcap, file);
    if (event.number != next_) {
      result_.lost = event.number - std::min(next_, event.number);
      if (result_.lost == 0)
        throw FileError(file + ": event " + std::to_string(event.number) + " comes after event " +
                        std::to_string(next_ - 1) +
                        "; give the files of one recording in their order, each once");
      return false;
    }
    ++next_;
    result_.time = seconds(event.time - first_);
    if (auto wrong = replayer_->take(event, mcap, file)) {
      result_.difference = {.event = event.number,
                            .time = result_.time,
                            .hand = event.hand,
                            .sample = sample_of(event),
                            .what = std::string(name(event.kind)) + ": " + *std::move(wrong)};
      return false;
    }
    count(event);
    return true;
  }

  void begin(const SceneEvent& event, const mcap::Reader& mcap, const std::string& file) {
    if (event.number != 1)
      throw FileError(file + ": begins with event " + std::to_string(event.number) +
                      ", and a replay needs all from the first; give all files of the recording. "
                      "A flight record, or a recording that an admin started later, is there to be "
                      "looked at");
    for (const mcap::Metadata& metadata : mcap.metadata()) {
      if (metadata.name != "feltwire") continue;
      result_.scene = value(metadata, "scene");
      result_.recorded_by = value(metadata, "build");
    }
    auto scene = given_ != nullptr ? given_ : kept_scene(mcap, 0, file);
    if (scene == nullptr)
      throw FileError(file + ": has no scene in it; name the scene's file with --scene");
    replayer_ = std::make_unique<Replayer>(std::move(scene), given_);
    first_ = event.time;
  }

  void count(const SceneEvent& event) {
    ++result_.events;
    result_.replies += event.outcome == EventOutcome::answered ? 1 : 0;
    result_.sessions += event.kind == EventKind::join ? 1 : 0;
    result_.ticks += event.kind == EventKind::tick ? 1 : 0;
  }

  static std::uint64_t sample_of(const SceneEvent& event) {
    SampleBatch batch;
    if (event.kind != EventKind::samples || decode(event.payload, batch) != DropReason::none)
      return 0;
    return batch.count > 0 ? batch.samples[0].index : 0;
  }

  std::shared_ptr<const Scene> given_;
  std::unique_ptr<Replayer> replayer_;
  OnReply on_reply_;
  EventReader events_;
  Replay result_;
  std::uint64_t next_ = 1;
  Nanoseconds first_{0};
};

}  // namespace

Replay replay(const std::vector<std::filesystem::path>& files, std::shared_ptr<const Scene> given,
              OnReply on_reply) {
  return Reading(files, std::move(given), std::move(on_reply)).result();
}

}  // namespace feltwire
