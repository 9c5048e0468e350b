#include "server/app/prometheus_metrics.hpp"

#include <optional>
#include <span>
#include <string_view>

#include "core/base/written_number.hpp"

namespace feltwire {
namespace {

/// Returns the value of a label with the escapes that the Prometheus text format requires.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
      continue;
    }
    if (c == '\\' || c == '"') result += '\\';
    result += c;
  }
  return result;
}

/// Adds the HELP and TYPE lines of a metric, which precede its first value.
void begin(std::string& text, std::string_view name, std::string_view kind, std::string_view help) {
  text.append("# HELP ").append(name).append(" ").append(help).append("\n# TYPE ");
  text.append(name).append(" ").append(kind).append("\n");
}

void value(std::string& text, std::string_view name, const std::string& labels,
           std::uint64_t number) {
  text.append(name);
  if (!labels.empty()) text.append("{").append(labels).append("}");
  text.append(" ").append(std::to_string(number)).append("\n");
}

struct SceneMetric {
  std::string_view name, kind, help;
  std::uint64_t (*of)(const SceneSummary& scene);
};

constexpr auto kSceneMetrics = std::to_array<SceneMetric>({
    {"feltwire_sessions", "gauge", "Sessions at this moment.",
     [](const SceneSummary& s) { return std::uint64_t{s.sessions}; }},
    {"feltwire_sessions_served_total", "counter", "Sessions that have joined.",
     [](const SceneSummary& s) { return s.counters.sessions_served; }},
    {"feltwire_datagrams_total", "counter", "Datagrams received.",
     [](const SceneSummary& s) { return s.counters.datagrams; }},
    {"feltwire_samples_total", "counter", "Servo samples taken.",
     [](const SceneSummary& s) { return s.counters.samples.samples; }},
    {"feltwire_samples_missed_total", "counter", "Servo samples lost on the way.",
     [](const SceneSummary& s) { return s.counters.samples.missed; }},
    {"feltwire_gaps_total", "counter", "Places where samples were lost on the way.",
     [](const SceneSummary& s) { return s.counters.samples.gaps; }},
    {"feltwire_duplicates_total", "counter", "Datagrams that brought nothing new.",
     [](const SceneSummary& s) { return s.counters.samples.duplicates; }},
    {"feltwire_client_late_ticks_total", "counter",
     "Servo ticks of clients that came a whole period late, as they report.",
     [](const SceneSummary& s) { return s.counters.samples.late_ticks; }},
    {"feltwire_late_goodbyes_total", "counter",
     "Datagrams under the number of a session that had just ended.",
     [](const SceneSummary& s) { return s.counters.late_goodbyes; }},
    {"feltwire_replies_total", "counter", "Commands sent.",
     [](const SceneSummary& s) { return s.counters.samples.replies; }},
    {"feltwire_replies_withheld_total", "counter", "Commands that a deadband kept back.",
     [](const SceneSummary& s) { return s.counters.samples.withheld; }},
    {"feltwire_replies_unsent_total", "counter", "Replies that the operating system did not take.",
     [](const SceneSummary& s) { return s.unsent; }},
    {"feltwire_shed_total", "counter",
     "Datagrams of sessions above their share that were dropped for want of time.",
     [](const SceneSummary& s) { return s.counters.shed; }},
    {"feltwire_slowed_total", "counter",
     "Times that a session was asked for fewer datagrams for want of time.",
     [](const SceneSummary& s) { return s.counters.slowed; }},
    {"feltwire_world_steps_total", "counter", "Steps of the moving objects.",
     [](const SceneSummary& s) { return s.counters.world.steps; }},
    {"feltwire_world_resets_total", "counter", "Steps that came to nothing sane.",
     [](const SceneSummary& s) { return s.counters.world.resets; }},
    {"feltwire_world_bodies_returned_total", "counter",
     "Moving objects that left the scene and were put back.",
     [](const SceneSummary& s) { return s.counters.world.returned; }},
    {"feltwire_world_warnings_total", "counter", "Warnings of the simulation of moving objects.",
     [](const SceneSummary& s) { return s.counters.world.warnings; }},
    {"feltwire_world_ticks_dropped_total", "counter",
     "Steps of the moving objects that were left out, as the thread could not keep up.",
     [](const SceneSummary& s) { return s.counters.ticks_dropped; }},
});

struct End {
  std::string_view how;
  std::uint64_t SceneCounters::*count;
};
constexpr auto kEnds = std::to_array<End>({
    {"left", &SceneCounters::left},
    {"silent", &SceneCounters::silent},
    {"flooded", &SceneCounters::flooded},
    {"forged", &SceneCounters::forged},
    {"evicted", &SceneCounters::evicted},
    {"disturbing", &SceneCounters::disturbing},
    {"failed", &SceneCounters::failed},
});

std::string scene_label(const std::string& scene) { return "scene=\"" + escaped(scene) + "\""; }
std::string scene_label(const SceneSummary& scene) { return scene_label(scene.scene); }

void add_scenes(std::string& text, const std::vector<SceneSummary>& scenes) {
  for (const SceneMetric& metric : kSceneMetrics) {
    begin(text, metric.name, metric.kind, metric.help);
    for (const SceneSummary& scene : scenes)
      value(text, metric.name, scene_label(scene), metric.of(scene));
  }
  constexpr std::string_view kEnded = "feltwire_sessions_ended_total";
  begin(text, kEnded, "counter", "Sessions that have ended, by how.");
  for (const SceneSummary& scene : scenes)
    for (const End& end : kEnds)
      value(text, kEnded, scene_label(scene) + ",how=\"" + std::string(end.how) + "\"",
            scene.counters.*end.count);
  constexpr std::string_view kDropped = "feltwire_datagrams_dropped_total";
  begin(text, kDropped, "counter", "Datagrams that were dropped, by the check that they failed.");
  for (const SceneSummary& scene : scenes)
    for (std::size_t i = 1; i < kDropReasons; ++i)
      value(text, kDropped,
            scene_label(scene) + ",reason=\"" + name(static_cast<DropReason>(i)) + "\"",
            scene.counters.drops[i]);
}

std::string in_seconds(Nanoseconds time) { return shortest_text(seconds(time)); }

/// Adds a histogram in which each class also counts the times of all classes below it. `limits`
/// [ns]: the upper limits of all classes but the last. `sum`: the sum of all times, if it is known.
void add_classes(std::string& text, const std::string& name, const std::string& labels,
                 std::span<const std::uint64_t> counts, const auto& limits,
                 std::optional<Nanoseconds> sum = {}) {
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    below += counts[i];
    const std::string limit = i < limits.size() ? in_seconds(Nanoseconds(limits[i])) : "+Inf";
    value(text, name + "_bucket", labels + ",le=\"" + limit + "\"", below);
  }
  if (sum) text.append(name).append("_sum{").append(labels).append("} ");
  if (sum) text.append(in_seconds(*sum)).append("\n");
  value(text, name + "_count", labels, below);
}

void add_times(std::string& text, const std::string& name, const std::string& labels,
               const TimeCounts& times) {
  add_classes(text, name, labels, times.counts(), TimeCounts::kLimits,
              Nanoseconds(static_cast<std::int64_t>(times.sum())));
}

void add_client_times(std::string& text, const std::vector<SceneSummary>& scenes) {
  const std::string wakeups = "feltwire_client_wakeup_late_seconds",
                    round_trips = "feltwire_client_round_trip_seconds";
  begin(text, wakeups, "histogram", "How late the servos of clients woke, as they report.");
  for (const SceneSummary& scene : scenes)
    add_classes(text, wakeups, scene_label(scene), scene.counters.client_wakeups,
                hand_time_limits::kWakeups);
  begin(text, round_trips, "histogram",
        "From when a device was read to the answer at its client, as clients report.");
  for (const SceneSummary& scene : scenes)
    add_classes(text, round_trips, scene_label(scene), scene.counters.client_round_trips,
                hand_time_limits::kRoundTrips);
}

void add_times(std::string& text, const std::vector<NamedTimes>& scenes) {
  const std::string answers = "feltwire_answer_seconds", late = "feltwire_world_late_seconds";
  begin(text, answers, "histogram",
        "From when a datagram was taken up to its answer, those taken up with it included.");
  for (const auto& [scene, times] : scenes)
    if (times.answers) add_times(text, answers, scene_label(scene), *times.answers);
  begin(text, late, "histogram", "How late the thread woke for the moving objects.");
  for (const auto& [scene, times] : scenes)
    if (times.world_late) add_times(text, late, scene_label(scene), *times.world_late);
}

std::vector<NamedTimes> times_of(const std::vector<SceneSummary>& scenes) {
  std::vector<NamedTimes> times;
  times.reserve(scenes.size());
  for (const SceneSummary& scene : scenes)
    times.push_back({scene.scene, {scene.answers, scene.counters.world_late}});
  return times;
}

void add(std::string& text, std::string_view name, std::string_view help, std::uint64_t number) {
  begin(text, name, "counter", help);
  value(text, name, {}, number);
}

}  // namespace

std::string metrics_text(const std::vector<SceneSummary>& scenes, const ControlSummary& control,
                         const web::ViewerHubCounters& page) {
  std::string text;
  add_scenes(text, scenes);
  add_times(text, times_of(scenes));
  add_client_times(text, scenes);
  const auto& [connections, requests] = control;
  add(text, "feltwire_control_connections_total", "Control connections accepted.",
      connections.accepted);
  add(text, "feltwire_control_too_often_total",
      "Control connections closed, as their network connects too often.", connections.too_often);
  add(text, "feltwire_control_crowded_out_total", "Control connections closed for newer ones.",
      connections.crowded_out);
  add(text, "feltwire_control_no_tls_total", "Control connections that came to no TLS.",
      connections.failed);
  add(text, "feltwire_control_too_slow_total", "Control connections whose token came too late.",
      connections.too_slow);
  add(text, "feltwire_requests_unauthenticated_total", "Requests without a good token.",
      requests.unauthenticated);
  add(text, "feltwire_requests_forbidden_total", "Requests beyond their token's role or scene.",
      requests.forbidden);
  add(text, "feltwire_requests_too_many_total", "Requests above a limit.", requests.too_many);
  return text + metrics_text(page, {});
}

std::string metrics_text(const web::ViewerHubCounters& page, const std::vector<NamedTimes>& times) {
  std::string text;
  if (!times.empty()) add_times(text, times);
  add(text, "feltwire_viewers_total", "Viewers of the live page.", page.viewers);
  add(text, "feltwire_viewers_refused_total", "Viewers without a good token, or too many.",
      page.refused);
  add(text, "feltwire_tickets_total", "Tickets given for viewers of the Foxglove protocol.",
      page.tickets);
  add(text, "feltwire_pictures_total", "Pictures sent to viewers.", page.pictures);
  add(text, "feltwire_pictures_skipped_total", "Turns at which a slow viewer was sent nothing.",
      page.skipped);
  add(text, "feltwire_page_hands_total", "Hands that viewers asked for.", page.hands);
  add(text, "feltwire_page_points_total", "Places that viewers pointed their hands to.",
      page.points);
  add(text, "feltwire_page_points_refused_total", "Places too far away, or that are none.",
      page.points_refused);
  return text;
}

}  // namespace feltwire
