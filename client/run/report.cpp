#include "client/run/report.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/run/device_report.hpp"
#include "client/run/device_words.hpp"
#include "client/run/json_values.hpp"
#include "client/run/link_states_json.hpp"
#include "client/transport/encoder.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"

namespace feltwire {
namespace report {
namespace {

constexpr double kMicrodegree = 1e-6;  // degrees per microdegree

Json energy(const ChannelEnergy& e) {
  return {{"elastic", number(e.elastic)},
          {"frictional", number(e.frictional)},
          {"torque", number(e.torque)}};
}

Json parameters(const SessionParameters& p) {
  return {{"mode", p.mode},
          {"projection", name(p.projection)},
          {"storage", name(p.storage)},
          {"side", name(p.side)},
          {"servo_period_s", number(p.servo_period)},
          {"redundancy", p.redundancy},
          {"operator_damping", number(p.operator_damping)},
          {"velocity_cutoff_hz", number(p.velocity_cutoff)},
          {"hold_time_s", number(p.hold_time)},
          {"c1", number(p.c1)},
          {"c2", number(p.c2)},
          {"reference", name(p.reference)},
          {"coupling_stiffness_n_per_m", number(p.coupling_stiffness)},
          {"coupling_damping_n_s_per_m", number(p.coupling_damping)},
          {"tool_mass_kg", number(p.tool_mass)},
          {"packet_interval", p.packet_interval},
          {"batch", p.batch},
          {"position_deadband", number(p.position_deadband)},
          {"force_deadband", number(p.force_deadband)},
          {"predictor", name(p.predictor)},
          {"keep_alive_s", number(p.keep_alive)},
          {"local_model", p.local_model}};
}

Json dropped(const TransportStatistics& transport, const ServoStatistics& servo) {
  Json reasons = Json::object();
  for (std::size_t i = 1; i < kDropReasons; ++i) {
    const auto reason = static_cast<DropReason>(i);
    // Only the servo detects stale replies.
    const std::uint64_t more = reason == DropReason::stale ? servo.replies.stale : 0;
    reasons[name(reason)] = transport.dropped[i] + more;
  }
  return reasons;
}

Json server(const Servo& servo) {
  if (!servo.has_reply()) return nullptr;
  const Reply& reply = servo.newest_reply();
  return {{"sample_index", reply.sample_index},
          {"energy_delivered_j", energy(reply.delivered)},
          {"ratio", number(reply.bound.ratio)},
          {"bound_active", reply.bound.active},
          {"saturated", reply.bound.saturated},
          {"refused", reply.bound.refused},
          {"gap", reply.gap},
          {"recovering", reply.recovering}};
}

/// Returns the limit of the contact work, or null if the client fetched nothing or has no limit.
Json allowed_work(const Servo& servo) {
  const FetchedScene* fetched = servo.fetched();
  if (fetched == nullptr || fetched->most_work == WorkLimit::kUnlimited) return nullptr;
  return fetched->most_work;
}

Json local_model(const Servo& servo, const std::string& contact_refused) {
  if (!servo.parameters().local_model) return nullptr;
  const ServoStatistics& s = servo.statistics();
  return {
      {"models", s.local_model.received},
      {"mean_patches", s.local_model.received > 0
                           ? number(static_cast<double>(s.local_model.patches) /
                                    static_cast<double>(s.local_model.received))
                           : Json(nullptr)},
      {"with_whole_surfaces", s.local_model.whole},
      {"samples_from_model", s.local_model.from_model},
      {"samples_from_both", s.local_model.from_both},
      {"samples_beyond_reach", s.local_model.beyond_reach},
      {"hand_overs", s.local_model.hand_overs},
      {"contact_refused", contact_refused.empty() ? Json(nullptr) : Json(visible(contact_refused))},
      {"contact_cut_samples", s.local_model.contact_cut},
      {"most_contact_work", s.local_model.most_work},
      {"allowed_contact_work", allowed_work(servo)}};
}

/// Returns when the watch thread releases a stalled device, and in which call the servo stalled.
Json let_go(const LoopResult& loop) {
  return {
      {"after_s", loop.let_go_after > 0.0 ? number(loop.let_go_after) : Json(nullptr)},
      {"still_s", loop.stood_still ? number(loop.still_for) : Json(nullptr)},
      {"in", loop.stood_still ? Json(enum_name(kDeviceCallNames, loop.still_in)) : Json(nullptr)}};
}

/// Returns the balance and the counts of the energy account, or null without an account.
Json account(const Servo& servo) {
  if (!servo.account()) return nullptr;
  const AccountStatistics& s = servo.account()->statistics();
  return {{"balance_j", number(servo.account()->balance())},
          {"overdrawn", s.overdrawn},
          {"largest_debt_j", number(s.largest_debt)},
          {"strong_hand_samples", s.strong_hand},
          {"hand_force_n", number(servo.account()->outside_force())}};
}

/// Returns the debt of the energy account that ended the force, or null.
Json debt_fault(const std::optional<Overdraft>& overdraft) {
  if (!overdraft) return nullptr;
  return {{"debt_j", number(overdraft->debt)},
          {"hold_time_s", number(overdraft->hold_time)},
          {"strong_hand", overdraft->strong_hand}};
}

/// Returns the values that the bounding method adapts to the hand, or null for other methods.
Json hand_credit(const std::optional<HandCredit>& credit) {
  if (!credit) return nullptr;
  return {{"damping_n_s_per_m", number(credit->damping)},
          {"steps_down", credit->steps_down},
          {"near_share", number(credit->near_share)},
          {"near_steps_down", credit->near_steps_down},
          {"untold_lag_s", number(credit->untold_lag)}};
}

/// Returns the ticks for each reason of zero force, and the main reason of a run without force.
Json no_force(const ServoStatistics& s) {
  Json samples = Json::object();
  for (std::size_t i = 1; i < kZeroForceReasons; ++i)
    samples[name(static_cast<ZeroForceReason>(i))] = s.no_force[i];
  const bool none = s.max_force < kFeltForce;
  return {{"run", none ? Json(name(prevailing(s.no_force))) : Json(nullptr)},
          {"samples", std::move(samples)}};
}

Json clock(const ClockEstimate& c, Nanoseconds now) {
  if (!c.known()) return nullptr;
  return {{"offset_s", number(c.offset(now))},
          {"error_bound_us", number(kMicro * c.error_bound())},
          {"drift_ppm", number(kMicro * c.drift())},
          {"delay_up_us", number(kMicro * c.delay_up())},
          {"delay_down_us", number(kMicro * c.delay_down())},
          {"jitter_up_us", number(kMicro * c.jitter_up())},
          {"jitter_down_us", number(kMicro * c.jitter_down())},
          {"restarts", c.restarts()},
          {"impossible", c.impossible()}};
}

Json flight_records(const std::vector<WrittenFlight>* written) {
  Json list = Json::array();
  if (written != nullptr)
    for (const WrittenFlight& flight : *written)
      list.push_back({{"file", flight.file.string()}, {"cause", flight.cause}});
  return list;
}

/// Returns the changes that admins requested, in the order of the requests.
Json changes(const std::deque<Changes::Done>* done) {
  Json list = Json::array();
  if (done == nullptr) return list;
  for (const Changes::Done& change : *done)
    list.push_back(
        {{"time_s", change.prepared.taken >= 0.0 ? number(change.prepared.taken) : Json(nullptr)},
         {"what", visible(change.what)},
         {"refused", change.refusal.empty() ? Json(nullptr) : Json(visible(change.refusal))}});
  return list;
}

Json states(const std::vector<LinkState>& robots) {
  Json list = Json::array();
  for (const LinkState state : robots) list.push_back(std::string(name(state)));
  return list;
}

/// Returns the link states of the robots, or null if the hand leads no robot.
Json robot(const Servo& servo) {
  if (!servo.remote()) return nullptr;
  return link_states_json(servo.link_states());
}

Json sight(const std::optional<SightCounts>& seen, const LoopResult& loop) {
  if (!seen) return nullptr;
  return {{"views", seen->views},           {"views_dropped", loop.views_dropped},
          {"hands", seen->hands},           {"bodies", seen->bodies},
          {"most_hands", seen->most_hands}, {"most_bodies", seen->most_bodies},
          {"robots", states(seen->robots)}, {"left_out", seen->left_out}};
}

/// Returns the port's text as JSON, or as a string if user code has made it invalid JSON.
Json port_json(const std::string& text) {
  if (text.empty()) return nullptr;
  Json parsed = Json::parse(text, nullptr, false);
  return parsed.is_discarded() ? Json(visible_lines(text)) : parsed;
}

constexpr std::array<std::string_view, 6> kGoodbyeReasonNames = {
    "leaving", "shutting_down", "evicted", "flooding", "failed", "disturbing"};

}  // namespace
}  // namespace report

std::string report_json(const RunDescription& run, const Servo& servo,
                        const TransportStatistics& transport, const LoopResult& loop,
                        const std::string& link) {
  using namespace report;
  const ServoStatistics& s = servo.statistics();
  const PortEnergy& port = servo.port();
  Json report = {
      {"client", run.client},
      {"scene", run.scene},
      {"tool", run.tool.empty() ? Json(nullptr) : Json(run.tool)},
      {"server", run.server},
      {"server_version", run.server_version.empty() ? Json(nullptr) : Json(run.server_version)},
      {"feltwire", {{"version", version()}, {"compiler", compiler()}, {"build", build_type()}}},
      {"device", device(run.device_kind, servo.spec())},
      {"duration_s", number(loop.duration)},
      {"end", name(loop.end)},
      {"samples", s.samples},
      {"sample_datagrams", s.replies.datagrams},
      {"answered", s.replies.answered},
      {"withheld", s.replies.withheld},
      {"lost", servo.lost()},
      {"late", s.replies.late},
      {"round_trip_us", times(s.replies.round_trip)},
      {"server_clock", clock(servo.server_clock(), servo.sample().client_time)},
      {"energy_delivered_j", energy(port.delivered())},
      {"energy_burned_j", number(port.burned())},
      {"least_energy_margin_j", number(port.least_margin())},
      {"bound_violations", port.violations()},
      {"true_energy", true_energy(run.true_energy)},
      {"rehearsal", rehearsal(run.rehearsal)},
      {"max_force_n", number(s.max_force)},
      {"no_force", no_force(s)},
      {"oscillation_um", micrometres(servo.measures().oscillation())},
      {"displayed_stiffness_n_per_m", number(servo.measures().displayed_stiffness())},
      {"direction_error_deg",
       {{"mean", mean_of(s.direction_error, kMicrodegree)},
        {"p99", quantile(s.direction_error, 0.99, kMicrodegree)},
        {"max", max_of(s.direction_error, kMicrodegree)}}},
      {"servo_wakeup_late_us", times(loop.wakeup_late)},
      {"overruns", loop.overruns},
      {"missed_deadlines", loop.missed_deadlines},
      {"let_go", let_go(loop)},
      {"faded_samples", s.faded},
      {"bound_active_samples", s.law.bound_active},
      {"account_cut_samples", s.law.account_cut},
      {"saturated_samples", s.law.saturated},
      {"waiting_samples", s.law.waiting},
      {"ramped_samples", s.law.ramped},
      {"slewed_samples", s.law.slewed},
      {"too_fast_samples", s.law.too_fast},
      {"force_limited_samples", s.law.force_limited},
      {"refused_samples", s.law.refused},
      {"device_faults", s.device.faults},
      {"device_jumps", s.device.jumps},
      {"device_trouble", text_or_null(trouble_text(servo.device_trouble(), loop.duration))},
      {"device_read_us", times(loop.device.read)},
      {"device_write_us", times(loop.device.write)},
      {"device_slow_ticks", loop.device.slow},
      {"device_slow",
       text_or_null(slow_device(loop.device, servo.parameters().servo_period, loop.paced))},
      {"stale_readings", s.device.stale_readings},
      {"forces_corrected", s.device.forces_corrected},
      {"replies_refused", s.replies.refused},
      {"scene_resets", s.replies.scene_resets},
      {"records_dropped", loop.records_dropped},
      {"disconnections", loop.disconnections},
      {"reconnections", loop.reconnections},
      {"disconnected_s", number(loop.disconnected)},
      {"datagrams",
       {{"sent", transport.sent},
        {"send_failed", transport.send_failed},
        {"too_long", transport.too_long},
        {"rerouted", transport.rerouted},
        {"received", transport.received},
        {"shortened", transport.shortened},
        {"pace", transport.pace}}},
      {"dropped", dropped(transport, s)},
      {"link", port_json(link)},
      {"check", port_json(run.check)},
      {"busy_poll_us", number(run.busy_poll)},
      {"real_time",
       {{"scheduler", run.real_time.scheduler}, {"memory_locked", run.real_time.memory_locked}}},
      {"parameters", parameters(servo.parameters())},
      {"safety", safety(servo.options().safety)},
      {"encoder", encoder(servo.spec(), run.scene_stiffness)},
      {"local_model", local_model(servo, run.contact_refused)},
      {"account", account(servo)},
      {"debt_fault", debt_fault(servo.overdraft())},
      {"hand_credit", hand_credit(servo.hand_credit())},
      {"robot", robot(servo)},
      {"role", run.sight ? name(Role::observer) : name(Role::operator_)},
      {"view", sight(run.sight, loop)},
      {"changes", changes(run.changes)},
      {"flight_records", flight_records(run.flight_records)},
      {"server_last_reply", server(servo)},
  };
  if (loop.end == EndReason::server_goodbye)
    report["goodbye_reason"] = enum_name(kGoodbyeReasonNames, loop.goodbye);
  // A name may contain any bytes, but the report must be valid JSON.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace feltwire
