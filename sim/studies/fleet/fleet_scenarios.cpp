#include "sim/studies/fleet/fleet_scenarios.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "server/fleet/record_codec.hpp"

namespace feltwire::fleet {
namespace {

constexpr double kLongest = 300.0;  // [s] after which a scenario has failed
constexpr double kStep = 1.0;       // [s] between looks at the fleet

std::unique_ptr<VirtualFleet> placed(const FleetInputs& inputs, std::uint32_t hosts) {
  auto fleet = std::make_unique<VirtualFleet>(inputs, hosts);
  if (!fleet->place_all())
    throw std::runtime_error(std::to_string(hosts) + " hosts do not hold all scenes; take more");
  fleet->reset_counts();
  return fleet;
}

std::unique_ptr<VirtualFleet> seated(const FleetInputs& inputs, std::uint32_t hosts) {
  auto fleet = placed(inputs, hosts);
  fleet->seat_all();
  return fleet;
}

std::uint32_t rack_size(const FleetInputs& inputs, std::uint32_t hosts) {
  return std::max<std::uint32_t>(
      1, static_cast<std::uint32_t>(std::lround(inputs.lost_hosts * hosts)));
}

bool settled(const VirtualFleet& fleet) {
  return fleet.hands_without_session() == 0 && fleet.scenes_without_standby() == 0 &&
         fleet.overfull_cores() == 0 && fleet.scenes_in_two_rooms() == 0;
}

/// Runs until the fleet is settled, and reports what happened since `begun`.
FleetRun settle(const std::string& name, VirtualFleet& fleet, double begun) {
  const double end = fleet.now() + kLongest;
  while (!settled(fleet) && fleet.now() < end) fleet.run(fleet.now() + kStep);
  FleetRun run{name, 0, 0.0, 0.0, settled(fleet), fleet.counts(), {}};
  const FleetCounts& counts = run.counts;
  run.hands = static_cast<std::uint32_t>(counts.joins);
  run.last_hand = std::max(0.0, counts.last_join - begun);
  run.rebalanced =
      std::max({counts.last_join, counts.last_standby, counts.last_overfull, begun}) - begun;
  return run;
}

std::string milliseconds(double microseconds) {
  constexpr double kMicrosecondsInAMillisecond = 1e3;
  return std::to_string(std::lround(microseconds / kMicrosecondsInAMillisecond)) + " ms";
}

SceneRecord typical_record() {
  SceneRecord record;
  record.owner.name = "host-100";
  record.owner.number = record.version.epoch.holder = ~HostNumber{0};
  record.version.epoch.term = record.version.change = 1;
  record.standby.name = "host-101";
  record.standby.number = 1;
  record.digest.fill(1);
  return record;
}

HostRecord typical_heartbeat(std::uint32_t cores) {
  HostRecord record;
  record.host.name = "host-100";
  record.host.number = ~HostNumber{0};
  record.beat = record.hands = record.late_p99_us = 1;
  record.addresses.emplace_back("192.0.2.100");
  record.control_port = 6720;
  record.version = "0.1.0";
  record.rack = "rack-10";
  record.ticket_keys.resize(kMostTicketKeys);
  constexpr std::uint8_t kFree = 10;  // [%]
  record.free_shares.assign(cores, kFree);
  return record;
}

/// Hands end their sessions, and others begin one in their place, at random times.
void come_and_go(VirtualFleet& fleet, double until, double per_second) {
  const double next = fleet.now() - std::log(1.0 - fleet.draws().uniform()) / per_second;
  if (next >= until) return;
  fleet.at(next, [&fleet, until, per_second] {
    fleet.lose(static_cast<std::uint32_t>(fleet.draws().uniform() * fleet.hands()), 0.0);
    come_and_go(fleet, until, per_second);
  });
}

/// New scenes are claimed at random times. Records how long each waits for the directory [us].
void start_scenes(VirtualFleet& fleet, double until, double per_second, Histogram& waited) {
  const double next = fleet.now() - std::log(1.0 - fleet.draws().uniform()) / per_second;
  if (next >= until) return;
  fleet.at(next, [&fleet, until, per_second, &waited] {
    const double begun = fleet.now();
    fleet.write(0, encode(typical_record()).size(), [&, begun] {
      waited.record(static_cast<std::int64_t>((fleet.now() - begun) * kMicroseconds));
    });
    start_scenes(fleet, until, per_second, waited);
  });
}

/// Two hosts in a hundred restart at a time, one after the other.
void restart_next(VirtualFleet& fleet, const std::shared_ptr<std::uint32_t>& next) {
  if (*next >= fleet.hosts()) return;
  fleet.drain((*next)++, [&fleet, next] { restart_next(fleet, next); });
}

}  // namespace

std::uint32_t least_hosts(const FleetInputs& inputs) {
  const auto all_fit = [&](std::uint32_t hosts) { return VirtualFleet(inputs, hosts).place_all(); };
  std::uint32_t too_few = 0, enough = 2;
  while (!all_fit(enough)) too_few = std::exchange(enough, 2 * enough);
  while (enough - too_few > 1) {
    const std::uint32_t middle = too_few + (enough - too_few) / 2;
    (all_fit(middle) ? enough : too_few) = middle;
  }
  return enough;
}

FleetRun lose_rack(const FleetInputs& inputs, std::uint32_t hosts, bool leader_too) {
  const auto owned = seated(inputs, hosts);
  VirtualFleet& fleet = *owned;
  if (leader_too) fleet.stall_directory(inputs.leader_loss);
  fleet.kill_hosts(0, rack_size(inputs, hosts));
  fleet.run(kStep);
  FleetRun run = settle(leader_too ? "rack and directory's leader lost" : "rack lost", fleet, 0.0);
  run.notes = {{"hosts lost", std::to_string(rack_size(inputs, hosts))},
               {"load of the fullest host then", std::to_string(fleet.highest_load())}};
  return run;
}

FleetRun lose_leader(const FleetInputs& inputs, std::uint32_t hosts) {
  const auto owned = seated(inputs, hosts);
  VirtualFleet& fleet = *owned;
  constexpr double kAt = 20.0, kEnd = 60.0;  // [s]
  Histogram started;
  come_and_go(fleet, kEnd, fleet.hands() / inputs.session);
  start_scenes(fleet, kEnd, inputs.scenes / inputs.session, started);
  fleet.run(kAt);
  const Histogram before = fleet.counts().without_session;
  fleet.reset_counts();
  fleet.stall_directory(kAt + inputs.leader_loss);
  fleet.run(kAt + inputs.leader_loss);
  const Histogram during = fleet.counts().without_session;
  fleet.run(kEnd);
  FleetRun run = settle("directory's leader lost", fleet, kAt);
  run.notes = {
      {"join, p99 before", milliseconds(before.quantile(0.99))},
      {"join, p99 meanwhile", milliseconds(during.quantile(0.99))},
      {"longest wait of a new scene's start", milliseconds(static_cast<double>(started.max()))}};
  return run;
}

FleetRun partition(const FleetInputs& inputs, std::uint32_t hosts) {
  const auto owned = seated(inputs, hosts);
  VirtualFleet& fleet = *owned;
  fleet.cut_off(0, 2 * rack_size(inputs, hosts));
  fleet.run(inputs.partition);
  const std::uint32_t in_two = fleet.scenes_in_two_rooms(), outside = fleet.hands_without_session();
  fleet.heal();
  FleetRun run = settle("partition of two racks", fleet, 0.0);
  run.notes = {{"scenes in two rooms meanwhile", std::to_string(in_two)},
               {"hands that stay outside meanwhile", std::to_string(outside)},
               {"last hand after the end",
                milliseconds((run.last_hand - inputs.partition) * kMicroseconds)}};
  return run;
}

FleetRun restart_all(const FleetInputs& inputs, std::uint32_t hosts) {
  const auto owned = seated(inputs, hosts);
  VirtualFleet& fleet = *owned;
  const auto next = std::make_shared<std::uint32_t>(0);
  constexpr double kShareAtOnce = 0.02;
  const auto at_once = std::max(1L, std::lround(kShareAtOnce * hosts));
  for (long i = 0; i < at_once; ++i) restart_next(fleet, next);
  constexpr double kMost = 7200.0;  // [s]
  const std::uint64_t all = fleet.hosts();
  while (fleet.now() < kMost && (*next < all || fleet.draining_hosts() > 0))
    fleet.run(fleet.now() + kStep);
  const double took = fleet.now();
  FleetRun run = settle("restart of all hosts", fleet, 0.0);
  run.notes = {
      {"hosts at once", std::to_string(at_once)},
      {"all hosts have restarted after", std::to_string(std::lround(took)) + " s"},
      {"hand without session, p99", milliseconds(run.counts.without_session.quantile(0.99))}};
  return run;
}

FleetRun everybody_joins(const FleetInputs& inputs, std::uint32_t hosts) {
  const auto owned = placed(inputs, hosts);
  VirtualFleet& fleet = *owned;
  constexpr double kWithin = 10.0;  // [s]
  for (std::uint32_t hand = 0; hand < fleet.hands(); ++hand)
    fleet.at(kWithin * fleet.draws().uniform(), [&fleet, hand] { fleet.lose(hand, 0.0); });
  fleet.run(kWithin);
  return settle("all hands join within 10 s", fleet, 0.0);
}

FleetStudy run_fleet(const FleetInputs& inputs) {
  FleetStudy study;
  study.inputs = inputs;
  study.least_hosts = least_hosts(inputs);
  // A rack more, and a tenth: a takeover does not pack as well as a placement of all scenes.
  constexpr double kSlack = 1.1;
  study.hosts =
      static_cast<std::uint32_t>(std::ceil(kSlack * study.least_hosts / (1.0 - inputs.lost_hosts)));
  {
    const auto fleet = placed(inputs, study.hosts);
    study.hands = fleet->hands();
    study.load = fleet->highest_load();
  }
  study.scene_record = encode(typical_record()).size();
  study.heartbeat = encode(typical_heartbeat(inputs.cores)).size();
  study.runs = {lose_rack(inputs, study.hosts, false), lose_rack(inputs, study.hosts, true),
                lose_leader(inputs, study.hosts),      partition(inputs, study.hosts),
                restart_all(inputs, study.hosts),      everybody_joins(inputs, study.hosts)};
  return study;
}

}  // namespace feltwire::fleet
