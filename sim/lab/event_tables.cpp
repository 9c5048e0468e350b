#include "sim/lab/event_tables.hpp"

#include <array>
#include <limits>
#include <string>

#include "protocol/net/clock.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {
namespace {

/// Returns the names of the reasons in a hand report (HandReason), such as "late+account". Returns
/// an empty text if there is no reason.
std::string reasons_text(double value) {
  const auto reasons = static_cast<std::uint32_t>(value);
  std::string text;
  for_each_reason(reasons, [&](std::string_view reason) {
    if (!text.empty()) text += '+';
    text += reason;
  });
  return text;
}

/// Returns the columns of a table of samples. The first columns have the same names as in a
/// client's recording.
std::vector<RecordingTable::Column> datagram_columns() {
  return {{"time", "t"},
          {"position", "x,y,z", 3},
          {"held", "rx,ry,rz", 3},
          {"held_elastic", "rex,rey,rez", 3},
          {"held_frictional", "rfx,rfy,rfz", 3},
          {"orientation", "qw,qx,qy,qz", 4},
          {"torque", "tx,ty,tz", 3},
          {"index", "index"}};
}

std::vector<RecordingTable::Column> report_columns() {
  return {{"time", "t"},
          {"balance", "balance"},
          {"round_trip", "round_trip"},
          {"hand_damping", "hand_damping"},
          {"late_ticks", "late_ticks"},
          {"reasons", "reasons", 1, &reasons_text}};
}

std::vector<RecordingTable::Column> reply_columns() {
  return {{"time", "t"},
          {"elastic", "ex,ey,ez", 3},
          {"frictional", "fx,fy,fz", 3},
          {"torque", "tx,ty,tz", 3},
          {"index", "index"},
          {"delivered", "delivered_elastic,delivered_frictional,delivered_torque", 3},
          {"ratio", "ratio"},
          {"active", "active"},
          {"saturated", "saturated"},
          {"refused", "refused"},
          {"gap", "gap"},
          {"recovering", "recovering"}};
}

RecordingTable& table_of(RecordingTables& tables, std::uint32_t hand, const char* what,
                         std::vector<RecordingTable::Column> (*columns)()) {
  return table_of(tables, "/hand_" + std::to_string(hand) + '/' + what, columns);
}

bool feels(Bytes join) {
  const auto request = control::decode(join);
  if (!request) return true;
  const auto* asked = std::get_if<control::JoinRequest>(&*request);
  return asked == nullptr || feels(asked->role);
}

}  // namespace

bool EventTables::add(const SceneEvent& event, std::uint64_t log_time) {
  Hand& hand = hands_[event.hand];
  if (event.kind == EventKind::join) hand.feels = feels(event.payload);
  if (event.kind != EventKind::samples || !hand.feels) return true;
  if (decode(event.payload, batch_) != DropReason::none) {
    // A flight record may begin after a robot has joined. Then this payload may be the state of the
    // robot.
    RobotState state;
    hand.feels = false;
    return decode(event.payload, state) == DropReason::none;
  }
  add_samples(event.hand, hand, log_time);
  return true;
}

void EventTables::add_samples(std::uint32_t number, Hand& hand, std::uint64_t log_time) {
  RecordingTable& table = table_of(tables_, number, "sample", &datagram_columns);
  for (int i = batch_.count; i-- > 0;) {
    const Sample& sample = batch_.samples[static_cast<std::size_t>(i)];
    if (sample.index <= hand.newest) continue;
    hand.newest = sample.index;
    if (!hand.start) hand.start = sample.client_time;
    const Vec3 &p = sample.pose.position, &e = sample.held.elastic, &f = sample.held.frictional,
               &t = sample.held.torque;
    const Vec3 r = sample.held.force();
    const Quaternion& q = sample.pose.orientation;
    table.add(log_time, std::array{seconds(sample.client_time - *hand.start),
                                   p.x(),
                                   p.y(),
                                   p.z(),
                                   r.x(),
                                   r.y(),
                                   r.z(),
                                   e.x(),
                                   e.y(),
                                   e.z(),
                                   f.x(),
                                   f.y(),
                                   f.z(),
                                   q.w(),
                                   q.x(),
                                   q.y(),
                                   q.z(),
                                   t.x(),
                                   t.y(),
                                   t.z(),
                                   static_cast<double>(sample.index)});
  }
  if (!batch_.report || !hand.start) return;
  const HandReport& report = *batch_.report;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  table_of(tables_, number, "report", &report_columns)
      .add(log_time,
           std::array{seconds(batch_.samples[0].client_time - *hand.start),
                      report.has_account ? report.balance : kNone,
                      report.round_trip > 0.0 ? report.round_trip : kNone, report.hand_damping,
                      static_cast<double>(report.late_ticks), static_cast<double>(report.reasons)});
}

void EventTables::add_reply(const SceneEvent& event, std::uint64_t log_time, Bytes payload) {
  const Hand& hand = hands_[event.hand];
  if (!hand.feels || !hand.start || decode(payload, reply_) != DropReason::none) return;
  const Vec3 &e = reply_.command.elastic, &f = reply_.command.frictional,
             &t = reply_.command.torque;
  table_of(tables_, event.hand, "reply", &reply_columns)
      .add(log_time, std::array{seconds(reply_.client_time - *hand.start),
                                e.x(),
                                e.y(),
                                e.z(),
                                f.x(),
                                f.y(),
                                f.z(),
                                t.x(),
                                t.y(),
                                t.z(),
                                static_cast<double>(reply_.sample_index),
                                reply_.delivered.elastic,
                                reply_.delivered.frictional,
                                reply_.delivered.torque,
                                reply_.bound.ratio,
                                static_cast<double>(reply_.bound.active),
                                static_cast<double>(reply_.bound.saturated),
                                static_cast<double>(reply_.bound.refused),
                                static_cast<double>(reply_.gap),
                                static_cast<double>(reply_.recovering)});
}

}  // namespace feltwire
