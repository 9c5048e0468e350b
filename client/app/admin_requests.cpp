#include "client/app/admin_requests.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "client/transport/false_answer.hpp"
#include "client/transport/listing.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMilliseconds = 1e3, kMillijoules = 1e3;  // per second, and per joule

double rate(const SessionParameters& parameters) { return 1.0 / parameters.servo_period; }

/// Returns the share of the client's samples that were lost, or nothing before the first sample.
std::optional<double> loss(const control::SessionDescription& session) {
  const double sent = static_cast<double>(session.samples) + static_cast<double>(session.missed);
  if (!(sent > 0.0)) return std::nullopt;
  return static_cast<double>(session.missed) / sent;
}

/// Returns the value as text, such as "12.5", or "-" for a missing value.
std::string cell(std::optional<double> value, int decimals) {
  if (!value) return "-";
  constexpr std::size_t kLongest = 400;  // characters; no double needs more
  std::string text(kLongest, '\0');
  text.resize(
      static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.*f", decimals, *value)));
  return text;
}

std::optional<double> scaled(double factor, std::optional<double> value) {
  return value ? std::optional(factor * *value) : std::nullopt;
}

Json number(std::optional<double> value) { return value ? Json(*value) : Json(nullptr); }

/// The names of control::RecordingEnd, and what each says to people.
constexpr std::array<std::pair<const char*, const char*>, 6> kRecordingEnds = {
    {{"none", ""},
     {"asked", ""},
     {"size", "its largest size was reached"},
     {"time", "its longest time was reached"},
     {"room", "the disk has too little room"},
     {"failed", "the file could not be written, and the server's log says why"}}};

std::string why_ended(control::RecordingEnd end) {
  const std::string why = kRecordingEnds.at(static_cast<std::size_t>(end)).second;
  return why.empty() ? "" : "; the last one ended: " + why;
}

Json json_of(const SeenSession& seen) {
  const auto& [scene, s] = seen;
  return {{"scene", visible(scene)},
          {"number", s.number},
          // The session id can exceed the exact range of JSON numbers, so write it as text.
          {"session", std::to_string(s.session)},
          {"client", visible(s.client)},
          {"device", visible(s.device)},
          {"tool", visible(s.tool)},
          {"role", name(s.role)},
          {"mode", visible(s.parameters.mode)},
          {"side", name(s.parameters.side)},
          {"local_model", s.parameters.local_model},
          {"rate_hz", rate(s.parameters)},
          {"samples", s.samples},
          {"missed", s.missed},
          {"loss", number(loss(s))},
          {"round_trip_ms", number(scaled(kMilliseconds, s.round_trip))},
          {"delivered_j", s.delivered},
          {"burned_j", s.burned},
          {"balance_j", number(s.balance)},
          {"laws_taken", name(s.changes.takes.laws)},
          {"link_taken", s.changes.takes.link},
          {"lead_share", s.lead_share},
          {"seat", s.seat.empty() ? Json(nullptr) : Json(visible(s.seat))},
          {"asked", s.changes.asked.empty() ? Json(nullptr) : Json(visible(s.changes.asked))},
          {"answer", s.changes.asked.empty() ? Json(nullptr) : Json(name(s.changes.answer))}};
}

/// Returns the rows as lines of text. Pads each column to the width of its widest cell.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i];
      if (i + 1 < row.size()) line.append(widths[i] - row[i].size() + 2, ' ');
    }
    text += line + "\n";
  }
  return text;
}

std::vector<std::string> scene_names(const ServerAccess& server) {
  std::vector<std::string> names;
  for (const control::SceneEntry& scene : list_scenes(server, kControlTimeout))
    names.push_back(scene.name);
  return names;
}

}  // namespace

std::string scene_named(const ServerAccess& server, const std::string& name) {
  if (!name.empty()) return name;
  const std::vector<std::string> names = scene_names(server);
  if (names.size() == 1) return names.front();
  std::string all;
  for (const std::string& scene : names) all += (all.empty() ? "" : ", ") + scene;
  throw std::invalid_argument(names.empty()
                                  ? "the token opens no scene of this server; use another token"
                                  : "--scene is required, the server has several scenes: " + all);
}

std::vector<std::string> scenes_named(const ServerAccess& server, const std::string& name) {
  return name.empty() ? scene_names(server) : std::vector{name};
}

SeenSessions sessions_of(const ServerAccess& server, const std::string& scene) {
  const std::vector<std::string> scenes = scenes_named(server, scene);
  SeenSessions seen;
  if (scenes.empty()) return seen;
  ControlDialogue dialogue(server, kControlTimeout);
  ListRoom room(kRoomOfServer);
  for (const std::string& name : scenes)
    for (auto told = described_sessions(dialogue, name, room); !told.empty(); told.pop_front())
      seen.push_back({name, std::move(told.front())});
  return seen;
}

const SeenSession& session_named(const SeenSessions& sessions, const std::string& name) {
  const SeenSession* found = nullptr;
  for (const SeenSession& seen : sessions) {
    if (std::to_string(seen.session.session) == name) return seen;
    if (std::to_string(seen.session.number) != name) continue;
    if (found != nullptr)
      throw std::invalid_argument("there is a session " + name + " in scene " + found->scene +
                                  " and in scene " + seen.scene + "; give --scene");
    found = &seen;
  }
  if (found != nullptr) return *found;
  throw std::invalid_argument("there is no session " + name +
                              "; feltwire-client admin sessions lists the existing ones");
}

std::vector<SeenCounters> counters_of(const ServerAccess& server) {
  std::vector<SeenCounters> seen;
  std::vector<std::string> scenes = scene_names(server);
  scenes.emplace_back();  // an empty name requests the counters of the control port
  seen.reserve(scenes.size());
  ListRoom room(kRoomOfCounters);
  for (const std::string& scene : scenes) {
    auto told = ask_for<control::Counters>(server, control::GetCounters{scene}).counters;
    for (const control::Counter& counter : told)
      if (!room.take(sizeof counter + counter.name.capacity()))
        throw FalseAnswer(to_string(server.endpoint) + " told counters of more than " +
                          std::to_string(room.bytes()) + " bytes");
    seen.push_back({scene, std::move(told)});
  }
  return seen;
}

std::string scene_table(const Endpoint& server, const std::vector<control::SceneEntry>& scenes) {
  std::array<char, 512> line{};
  const auto row = [&](const char* name, const std::string& port, const std::string& objects,
                       const std::string& clients) {
    std::snprintf(line.data(), line.size(), "%8s %8s %8s\n", port.c_str(), objects.c_str(),
                  clients.c_str());
    std::string text(name);
    constexpr std::size_t kNameWidth = 24;
    text.resize(std::max(kNameWidth, text.size()), ' ');
    return text + " " + line.data();
  };
  std::string text = row("scene", "port", "objects", "clients");
  for (const control::SceneEntry& scene : scenes)
    text +=
        row(visible(scene.name).c_str(), std::to_string(unsigned{server.port} + scene.port_offset),
            std::to_string(scene.objects), std::to_string(scene.sessions));
  return text;
}

std::string scene_json(const Endpoint& server, const std::vector<control::SceneEntry>& scenes) {
  Json all = Json::array();
  for (const control::SceneEntry& scene : scenes)
    all.push_back({{"scene", visible(scene.name)},
                   {"port", unsigned{server.port} + scene.port_offset},
                   {"objects", scene.objects},
                   {"clients", scene.sessions}});
  return all.dump(2) + "\n";
}

std::string text_of(const SeenSession& seen) {
  return "session " + std::to_string(seen.session.number) + " of scene " + visible(seen.scene);
}

AnswerFields fields_of(const SeenSession& seen) {
  return {{"scene", visible(seen.scene)},
          {"number", seen.session.number},
          {"session", std::to_string(seen.session.session)}};
}

std::string answer_json(const AnswerFields& fields) {
  Json all = Json::object();
  for (const auto& [name, value] : fields)
    std::visit([&, &key = name](const auto& known) { all[key] = known; }, value);
  return all.dump();
}

std::string json_list(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : ",\n") + value;
  return "[" + text + "]\n";
}

std::string session_table(const SeenSessions& sessions) {
  std::vector<std::vector<std::string>> rows = {
      {"scene", "number", "client", "device", "mode", "side", "rate/Hz", "loss/%", "trip/ms",
       "delivered/mJ", "burned/mJ", "balance/mJ", "session"}};
  for (const auto& [scene, s] : sessions) {
    const bool observes = s.role == Role::observer;
    rows.push_back({visible(scene), std::to_string(s.number), visible(s.client), visible(s.device),
                    observes ? "observer" : visible(s.parameters.mode),
                    observes ? "-" : std::string(name(s.parameters.side)),
                    cell(rate(s.parameters), 0), cell(scaled(kPercent, loss(s)), 2),
                    cell(scaled(kMilliseconds, s.round_trip), 2),
                    cell(kMillijoules * s.delivered, 2), cell(kMillijoules * s.burned, 2),
                    cell(scaled(kMillijoules, s.balance), 2), std::to_string(s.session)});
  }
  return aligned(rows);
}

void write_session_json(const SeenSessions& sessions,
                        const std::function<void(std::string_view piece)>& write) {
  if (sessions.empty()) return write("[]\n");
  constexpr std::string_view kOpen = "[\n", kClose = "\n]";
  std::string_view before = kOpen;
  for (const SeenSession& seen : sessions) {
    // Write each session separately. One JSON document of all sessions would need ten times the
    // memory of `sessions`.
    const std::string one = Json::array({json_of(seen)}).dump(2);
    write(before);
    write(std::string_view(one).substr(kOpen.size(), one.size() - kOpen.size() - kClose.size()));
    before = ",\n";
  }
  write(kClose);
  write("\n");
}

std::string counter_lines(const std::vector<SeenCounters>& counters) {
  std::string text;
  for (const SeenCounters& seen : counters) {
    text += seen.scene.empty() ? "control port\n" : "scene " + visible(seen.scene) + "\n";
    for (const control::Counter& counter : seen.counters)
      text += "  " + visible(counter.name) + " " + std::to_string(counter.value) + "\n";
  }
  return text;
}

std::string recordings_lines(const control::SceneRecordings& recordings) {
  const std::filesystem::path folder = recordings.folder;
  const auto size = [](std::uint64_t bytes) {
    constexpr double kMegabyte = 1e6;
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << static_cast<double>(bytes) / kMegabyte << " MB";
    return text.str();
  };
  std::ostringstream lines;
  lines << "scene " << visible(recordings.scene) << ": ";
  if (!recordings.running.empty())
    lines << "records to " << visible((folder / recordings.running).string()) << " since "
          << std::fixed << std::setprecision(0) << recordings.seconds << " s, "
          << size(recordings.bytes);
  else
    lines << "no recording runs" << why_ended(recordings.ended);
  lines << "\n";
  for (const control::KeptRecording& kept : recordings.kept)
    lines << "  " << visible((folder / kept.name).string()) << "  " << size(kept.bytes) << "\n";
  return lines.str();
}

std::string recordings_json(const control::SceneRecordings& recordings) {
  const bool runs = !recordings.running.empty();
  Json kept = Json::array();
  for (const control::KeptRecording& file : recordings.kept)
    kept.push_back({{"name", visible(file.name)}, {"bytes", file.bytes}});
  const Json told = {{"scene", visible(recordings.scene)},
                     {"folder", visible(recordings.folder)},
                     {"running", runs ? Json(visible(recordings.running)) : Json()},
                     {"seconds", recordings.seconds},
                     {"bytes", recordings.bytes},
                     {"ended", kRecordingEnds.at(static_cast<std::size_t>(recordings.ended)).first},
                     {"kept", std::move(kept)}};
  return told.dump(2);
}

std::string counter_json(const std::vector<SeenCounters>& counters) {
  Json all = {{"scenes", Json::array()}, {"control", Json::object()}};
  for (const SeenCounters& seen : counters) {
    Json values = Json::object();
    if (!seen.scene.empty()) values["scene"] = visible(seen.scene);
    for (const control::Counter& counter : seen.counters)
      values[visible(counter.name)] = counter.value;
    if (seen.scene.empty())
      all["control"] = std::move(values);
    else
      all["scenes"].push_back(std::move(values));
  }
  return all.dump(2) + "\n";
}

}  // namespace feltwire
