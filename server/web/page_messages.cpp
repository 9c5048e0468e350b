#include "server/web/page_messages.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/little_endian.hpp"
#include "core/bounding/method.hpp"
#include "core/build_info/build_info.hpp"
#include "core/local_model/local_model.hpp"
#include "protocol/session/bound_words.hpp"
#include "protocol/session/material_fields.hpp"
#include "server/access/json_text.hpp"
#include "server/web/object_triangles.hpp"
#include "server/web/value_texts.hpp"

namespace feltwire::web {
namespace {

static_assert(kHandStates + kHandReasons <= 32, "both are bits of one word");

using json_text::number;
using json_text::text;

// The kind of a binary message, which is its first byte.
enum class Kind : std::uint8_t { geometry = 1, picture = 2, surfaces = 3 };

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string text_or_null(const std::string& value) { return value.empty() ? "null" : text(value); }

/// Returns the limits of the histogram's classes [s] as a JSON list.
std::string limits(const HandTimes::Limits& times) {
  std::vector<std::string> entries;
  for (const std::chrono::nanoseconds time : times) entries.push_back(number(seconds(time)));
  return json_text::list(entries);
}
std::string counts(const HandTimesHeard& times, const HandTimesHeard::Totals& totals) {
  if (!times.heard()) return "null";
  std::vector<std::string> entries;
  for (const std::uint64_t total : totals) entries.push_back(number(total));
  return json_text::list(entries);
}

/// Builds a binary message from its first field to its last.
class Writer {
 public:
  Writer(Kind kind, std::size_t size) {
    bytes_.reserve(size);
    bytes_.assign({static_cast<std::uint8_t>(kind), 0, 0, 0});
  }
  void put(std::uint32_t value) { append(value); }
  void put(double value) { append(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void put_time(double value) { append(std::bit_cast<std::uint64_t>(value)); }
  void put(const Vec3& v) {
    for (const double value : v) put(value);
  }
  void put(const Quaternion& q) {
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) put(value);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class Unsigned>
  void append(Unsigned value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(Unsigned));
    put_little_endian(bytes_.data() + at, value);
  }
  Bytes bytes_;
};

constexpr int kRobotSeat = 8;  // position of the seat's lowest bit in the flags

void put(Writer& writer, const SeenRobot& robot) {
  writer.put(static_cast<std::uint32_t>(robot.state));
  writer.put(robot.hand);
  writer.put((robot.force ? 1u : 0u) | (robot.ok ? 2u : 0u) | (robot.stopped ? 4u : 0u) |
             (robot.touches ? 8u : 0u) | std::uint32_t{robot.seat} << kRobotSeat);
  for (const Pose* pose : {&robot.pose, &robot.target}) {
    writer.put(pose->position);
    writer.put(pose->orientation);
  }
  writer.put(robot.force.value_or(Vec3::Zero()));
  writer.put(robot.torque);
  for (const double value : {robot.gripper, robot.age}) writer.put(value);
}

/// Returns whether the reason reduces the force on the hand.
bool takes_off(HandReason reason) {
  return reason != HandReason::near && reason != HandReason::late;
}

const HandRates* rates_of(std::span<const HandRates> rates, std::uint32_t hand) {
  const auto found = std::ranges::lower_bound(rates, hand, {}, &HandRates::number);
  return found != rates.end() && found->number == hand ? &*found : nullptr;
}

}  // namespace

std::string hello(std::span<const std::string> scenes, Role role, bool observes) {
  std::vector<std::string> names, reasons, modes;
  for (const BoundingMethod* method : bounding_methods()) modes.push_back(text(method->name));
  for (const std::string& scene : scenes) names.push_back(text(scene));
  const auto add = [&](std::string_view reason, std::string_view sentence, bool cuts) {
    reasons.push_back(json_text::object(
        {{"name", text(reason)}, {"text", text(sentence)}, {"cuts", flag_text(cuts)}}));
  };
  for (std::size_t i = 0; i < kHandStates; ++i) {
    const auto state = static_cast<HandState>(i);
    add(name(state), feltwire::text(state), feltwire::takes_off(state));
  }
  for (std::size_t i = 0; i < kHandReasons; ++i)
    add(kHandReasonTexts[i].first, kHandReasonTexts[i].second,
        takes_off(static_cast<HandReason>(i)));
  return json_text::object({{"type", text("hello")},
                            {"version", text(version())},
                            {"scenes", json_text::list(names)},
                            {"role", text(name(role))},
                            {"modes", json_text::list(modes)},
                            {"wakeup_limits", limits(hand_time_limits::kWakeups)},
                            {"round_trip_limits", limits(hand_time_limits::kRoundTrips)},
                            {"small_debt", number(kSmallDebt)},
                            {"observes", flag_text(observes)},
                            {"reasons", json_text::list(reasons)}});
}

std::string ticket_text(std::string_view scene, std::string_view ticket,
                        std::chrono::seconds life) {
  return json_text::object({{"type", text("ticket")},
                            {"scene", text(scene)},
                            {"path", text("/foxglove?ticket=" + std::string(ticket))},
                            {"seconds", json_text::number(std::int64_t{life.count()})}});
}

std::string materials_text(const Scene& scene, std::uint32_t version,
                           const std::optional<Vec3>& gravity) {
  std::vector<std::string> entries;
  for (const Object& object : scene.objects()) {
    std::vector<json_text::Member> fields;
    fields.reserve(std::size(kMaterialFields));
    for (const MaterialField& field : kMaterialFields)
      fields.emplace_back(field.name, number(object.material.*field.value));
    entries.push_back(json_text::object(fields));
  }
  return json_text::object({{"type", text("materials")},
                            {"version", number(std::uint64_t{version})},
                            {"gravity", gravity ? vector_text(*gravity) : "null"},
                            {"objects", json_text::list(entries)}});
}

std::string changed_text(std::string_view what) {
  return json_text::object({{"type", text("changed")}, {"text", text(what)}});
}

std::string refused(std::string_view reason) {
  return json_text::object({{"type", text("refused")}, {"text", text(reason)}});
}

std::string recordings_text(const control::SceneRecordings& recordings) {
  constexpr std::array<const char*, 6> kEnds = {"none", "asked", "size", "time", "room", "failed"};
  std::vector<std::string> kept;
  kept.reserve(recordings.kept.size());
  for (const control::KeptRecording& file : recordings.kept)
    kept.push_back(json_text::object({{"name", text(file.name)}, {"bytes", number(file.bytes)}}));
  return json_text::object(
      {{"type", text("recordings")},
       {"scene", text(recordings.scene)},
       {"running", recordings.running.empty() ? "null" : text(recordings.running)},
       {"seconds", number(std::floor(recordings.seconds))},
       {"bytes", number(recordings.bytes)},
       {"ended", text(kEnds.at(static_cast<std::size_t>(recordings.ended)))},
       {"kept", json_text::list(kept)}});
}

std::string download_text(std::string_view name, std::string_view ticket) {
  return json_text::object({{"type", text("download")},
                            {"name", text(name)},
                            {"path", text("/recording?ticket=" + std::string(ticket))}});
}

std::string admin_text() {
  return json_text::object({{"type", text("admin")}, {"role", text(name(Role::admin))}});
}

std::string log_text(std::string_view level, std::string_view line) {
  return json_text::object({{"type", text("log")}, {"level", text(level)}, {"text", text(line)}});
}

std::vector<Bytes> geometry(const Scene& scene, std::uint32_t version) {
  std::vector<Bytes> messages;
  const std::vector<Object>& objects = scene.objects();
  const std::size_t still = scene.views().front().still();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const TriangleSoup soup = triangles_of(objects[i].shape);
    if (soup.triangles.empty()) continue;
    constexpr std::size_t kHead = 20, kCorners = 12;
    Writer writer(Kind::geometry,
                  kHead + kCorners * (soup.vertices.size() + soup.triangles.size()));
    writer.put(static_cast<std::uint32_t>(i));
    writer.put(version);
    writer.put(static_cast<std::uint32_t>(soup.vertices.size()));
    writer.put(static_cast<std::uint32_t>(soup.triangles.size()));
    for (const Vec3& vertex : soup.vertices)
      writer.put(i < still ? objects[i].pose.position + objects[i].pose.orientation * vertex
                           : vertex);
    for (const Triangle& triangle : soup.triangles)
      for (const std::uint32_t corner : triangle) writer.put(corner);
    messages.push_back(writer.take());
  }
  return messages;
}

Bytes picture(const Picture& picture, std::span<const HandRates> rates, Nanoseconds begin) {
  constexpr std::size_t kHead = 24, kHand = 112, kBody = 32, kRobot = 100;
  Writer writer(Kind::picture, kHead + kHand * picture.hands.size() +
                                   kBody * picture.bodies.size() + kRobot * picture.robots.size());
  writer.put(static_cast<std::uint32_t>(picture.hands.size()));
  writer.put(static_cast<std::uint32_t>(picture.bodies.size()));
  writer.put(picture.version);
  writer.put_time(seconds(picture.time - begin));
  for (const PictureHand& hand : picture.hands) {
    const HandRates* rate = rates_of(rates, hand.number);
    writer.put(hand.number);
    writer.put(hand.states | (hand.report ? hand.report->reasons << kHandStates : 0u));
    writer.put(hand.pose.position);
    writer.put(hand.pose.orientation);
    for (const Vec3* v : {&hand.proxy, &hand.elastic, &hand.frictional, &hand.held}) writer.put(*v);
    writer.put(hand.depth);
    writer.put(hand.delivered);
    writer.put(hand.burned);
    writer.put(hand.report && hand.report->has_account ? hand.report->balance : kUnknown);
    writer.put(rate != nullptr ? rate->samples : 0.0);
    writer.put(rate != nullptr ? rate->loss : 0.0);
    writer.put(hand.report && hand.report->round_trip > 0.0 ? hand.report->round_trip : kUnknown);
  }
  for (const PictureBody& body : picture.bodies) {
    writer.put(body.object);
    writer.put(body.pose.position);
    writer.put(body.pose.orientation);
  }
  for (const SeenRobot& robot : picture.robots) put(writer, robot);
  return writer.take();
}

Bytes surfaces(const Picture& picture) {
  constexpr std::size_t kHead = 12, kPatch = 60;
  std::size_t count = 0;
  for (const PictureHand& hand : picture.hands) count += hand.surfaces.view().size();
  if (count == 0) return {};
  Writer writer(Kind::surfaces, kHead + kPatch * count);
  writer.put(picture.version);
  writer.put(static_cast<std::uint32_t>(count));
  for (const PictureHand& hand : picture.hands) {
    for (const SurfacePatch& patch : hand.surfaces.view()) {
      writer.put(hand.number);
      writer.put((patch.touching ? 1u : 0u) | (patch.slipping ? 2u : 0u));
      for (const Vec3* v : {&patch.point, &patch.normal, &patch.axis}) writer.put(*v);
      writer.put(patch.curvature);
      writer.put(patch.radius);
      writer.put(hand.surfaces.reach);
      writer.put(patch.offset);
    }
  }
  return writer.take();
}

std::string sessions(std::span<const HandDescription> hands, const Picture& picture,
                     std::span<const HandRates> rates, double time) {
  std::vector<std::string> entries;
  for (const HandDescription& hand : hands) {
    const HandRates* rate = rates_of(rates, hand.number);
    const auto seen = std::ranges::find(picture.hands, hand.number, &PictureHand::number);
    const bool known = seen != picture.hands.end();
    const auto& parameters = hand.parameters;
    const double period = parameters ? parameters->servo_period : kUnknown;
    std::vector<json_text::Member> members = {
        {"number", number(std::uint64_t{hand.number})},
        {"session", text(std::to_string(hand.session))},  // JavaScript numbers have too few bits
        {"client", text_or_null(hand.client)},
        {"device", text_or_null(hand.device)},
        {"tool", text(hand.tool)},
        {"mode", parameters ? text(parameters->mode) : "null"},
        {"side", parameters ? text(name(parameters->side)) : "null"},
        {"projection", parameters ? text(name(parameters->projection)) : "null"},
        {"storage", parameters ? text(name(parameters->storage)) : "null"},
        {"reference", parameters ? text(name(parameters->reference)) : "null"},
        {"laws_taken", text(name(hand.changes.takes.laws))},
        {"link_taken", flag_text(hand.changes.takes.link)},
        {"lead_share", hand.lead_share ? number(*hand.lead_share) : "null"},
        {"asked", text_or_null(hand.changes.asked)},
        {"answer", hand.changes.asked.empty() ? "null" : text(name(hand.changes.answer))},
        {"local_model", parameters ? flag_text(parameters->local_model) : "null"},
        {"rate_hz", number(1.0 / period)},
        {"packet_hz", parameters ? number(1.0 / (period * parameters->packet_interval)) : "null"},
        {"samples_per_s", rate != nullptr ? number(rate->samples) : "null"},
        {"loss", rate != nullptr ? number(rate->loss) : "null"},
        {"round_trip_ms", known && seen->report && seen->report->round_trip > 0.0
                              ? number(1e3 * seen->report->round_trip)
                              : "null"},
        {"hand_damping", known && seen->report && seen->report->hand_damping > 0.0
                             ? number(seen->report->hand_damping)
                             : "null"},
        {"late_ticks",
         known && seen->report ? number(std::uint64_t{seen->report->late_ticks}) : "null"},
        {"wakeups", counts(hand.times, hand.times.wakeups())},
        {"round_trips", counts(hand.times, hand.times.round_trips())},
        {"delivered_j", known ? number(seen->delivered) : "null"},
        {"burned_j", known ? number(seen->burned) : "null"},
        {"samples", known ? number(seen->samples) : "null"},
        {"seconds", hand.joined && known
                        ? number(std::max(seconds(picture.time - *hand.joined), 0.0))
                        : "null"}};
    for (const BoundNumber& entry : kBoundNumbers) {
      const auto value = parameters ? value_of(entry, *parameters) : std::nullopt;
      members.emplace_back(entry.name, value ? number(*value) : "null");
    }
    entries.push_back(json_text::object(members));
  }
  return json_text::object(
      {{"type", text("sessions")}, {"time", number(time)}, {"sessions", json_text::list(entries)}});
}

std::string hand_text(const PageHand::Status& status) {
  if (status.state == PageHand::State::joining) return hand_text("joining");
  if (status.state == PageHand::State::released) return hand_text("released", status.reason);
  return json_text::object({{"type", text("hand")},
                            {"state", text("held")},
                            {"session", text(std::to_string(status.session))},
                            {"start", vector_text(status.start)},
                            {"stiffness", number(status.stiffness)},
                            {"reach", number(status.reach)}});
}

std::string hand_text(std::string_view state, std::string_view reason) {
  std::vector<json_text::Member> members = {{"type", text("hand")}, {"state", text(state)}};
  if (!reason.empty()) members.emplace_back("reason", text(reason));
  return json_text::object(members);
}

}  // namespace feltwire::web
