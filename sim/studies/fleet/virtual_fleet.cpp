#include "sim/studies/fleet/virtual_fleet.hpp"

#include <algorithm>
#include <utility>

#include "server/fleet/record_codec.hpp"

namespace feltwire::fleet {
namespace {

constexpr std::size_t kMessageBytes = 100;  // of a subject, its headers and TCP/IP. Assumption
constexpr std::uint32_t kMovesAtOnce = 8;   // of one host that drains
constexpr double kRebalanceEvery = 5.0;     // [s]

}  // namespace

VirtualFleet::VirtualFleet(const FleetInputs& inputs, std::uint32_t hosts)
    : inputs_(inputs), draws_(inputs.seed) {
  const auto rack = std::max<std::uint32_t>(
      1, static_cast<std::uint32_t>(std::lround(inputs.lost_hosts * hosts)));
  for (std::uint32_t host = 0; host < hosts; ++host) {
    hosts_.push_back(
        {{"host-" + std::to_string(host), ++started_}, "rack-" + std::to_string(host / rack)});
    rooms_.push_back({started_, std::vector<double>(inputs.cores, 1.0), false});
  }
  scenes_.resize(inputs.scenes);
  const std::uint32_t range = inputs.most_hands - inputs.fewest_hands + 1;
  for (std::uint32_t at = 0; at < inputs.scenes; ++at) {
    Scene& scene = scenes_[at];
    scene.hands = inputs.fewest_hands + static_cast<std::uint32_t>(draws_.uniform() * range);
    scene.first_hand = this->hands();
    scene.cost = scene_cost(scene.hands, inputs.hand_share, inputs.scene_share);
    hands_.resize(hands_.size() + scene.hands, Hand{{}, at});
  }
}

void VirtualFleet::at(double time, std::function<void()> action) {
  events_.push({std::max(time, now_), ordered_++, std::move(action)});
}

void VirtualFleet::run(double end) {
  while (!events_.empty() && events_.top().time < end) {
    now_ = events_.top().time;
    const std::function<void()> action = events_.top().action;
    events_.pop();
    action();
  }
  now_ = end;
}

std::size_t VirtualFleet::take_core(std::uint32_t scene, std::uint32_t host) {
  std::vector<double>& free = rooms_[host].free_cores;
  // A standby that has no room takes the scene all the same, and gives one away soon.
  const auto freest = static_cast<std::size_t>(std::ranges::max_element(free) - free.begin());
  const std::size_t core = core_for(rooms_[host], scenes_[scene].cost).value_or(freest);
  free[core] -= scenes_[scene].cost.core_share;
  return core;
}

void VirtualFleet::occupy(std::uint32_t scene, std::uint32_t host, std::size_t core) {
  scenes_[scene].core = core;
  scenes_[scene].owner = host;
  hosts_[host].scenes.push_back(scene);
}

void VirtualFleet::vacate(std::uint32_t scene, std::uint32_t host, std::size_t core) {
  rooms_[host].free_cores[core] += scenes_[scene].cost.core_share;
  std::erase(hosts_[host].scenes, scene);
}

std::vector<HostNumber> VirtualFleet::rack_of(std::uint32_t host) const {
  std::vector<HostNumber> numbers;
  for (const Host& other : hosts_)
    if (other.rack == hosts_[host].rack) numbers.push_back(other.self.number);
  return numbers;
}

bool VirtualFleet::place_all() {
  for (std::uint32_t at = 0; at < scenes_.size(); ++at) {
    const auto host = place(rooms_, scenes_[at].cost, draws_.bits());
    if (!host) return false;
    Scene& scene = scenes_[at];
    const auto owner = static_cast<std::uint32_t>(*host);
    occupy(at, owner, take_core(at, owner));
    const SceneRecord claimed = claim(scene.at_owner, hosts_[*host].self, {});
    finish_claim(scene.at_owner, claimed, ++revision_);
  }
  for (std::uint32_t at = 0; at < scenes_.size(); ++at) {
    Scene& scene = scenes_[at];
    const auto standby = place(rooms_, scene.cost, draws_.bits(), rack_of(scene.owner));
    if (!standby) return false;
    reserve_standby(scene.at_owner, hosts_[*standby].self);
    finish_write(scene.at_owner, scene.at_owner.record, ++revision_);
    see_record(scene.at_standby, scene.at_owner.record, revision_);
    scene.standby = static_cast<std::uint32_t>(*standby);
  }
  return true;
}

void VirtualFleet::seat_all() {
  at(now_ + kRebalanceEvery, [this] { rebalance(); });
  for (Hand& hand : hands_) take_session(hand.known, *scenes_[hand.scene].at_owner.serving);
}

void VirtualFleet::write(std::uint32_t host, std::size_t bytes, std::function<void()> done) {
  if (hosts_[host].cut) return;  // heal() writes again
  const double each = static_cast<double>(bytes + kMessageBytes);
  // To the leader, from it to two followers, and to every host that watches.
  const double whole = each * (3.0 + static_cast<double>(hosts_.size()));
  ++counts_.writes;
  counts_.bytes += whole;
  counts_.bytes_by_second.add(now_ - counted_from_, whole);
  directory_free_ = std::max(now_, directory_free_) + 1.0 / inputs_.writes_per_second;
  at(directory_free_ + inputs_.write.draw(draws_), std::move(done));
}

void VirtualFleet::write_record(std::uint32_t at) {
  const auto record = record_to_write(scenes_[at].at_owner);
  if (!record) return;
  write(scenes_[at].owner, encode(*record).size(), [this, at, record = *record] {
    Scene& scene = scenes_[at];
    const std::uint64_t revision = ++revision_;
    finish_write(scene.at_owner, record, revision);
    release_former(at, record, revision);
    if (scene.at_owner.record != record) return;
    if (record.standby.number == 0) return name_standby(at);
    for (std::uint32_t host = 0; host < hosts_.size(); ++host)
      if (hosts_[host].self == record.standby) scene.standby = host;
    if (scene.standby == kNobody || !hosts_[scene.standby].alive) return;
    scene.at_standby = {};
    see_record(scene.at_standby, record, revision);
    counts_.last_standby = now_;
  });
}

void VirtualFleet::release_former(std::uint32_t at, const SceneRecord& record,
                                  std::uint64_t revision) {
  Scene& scene = scenes_[at];
  if (scene.former == kNobody || hosts_[scene.former].cut ||
      !see_record(scene.at_former, record, revision))
    return;
  // It says goodbye `moved` to the hands that it still has.
  for (std::uint32_t hand = scene.first_hand; hand < scene.first_hand + scene.hands; ++hand) {
    const SessionEpoch& known = hands_[hand].known;
    if (known.session && *known.session < record.version.epoch) lose(hand, 0.0);
  }
  vacate(at, std::exchange(scene.former, kNobody), scene.former_core);
}

void VirtualFleet::name_standby(std::uint32_t at) {
  Scene& scene = scenes_[at];
  scene.standby = kNobody;
  const auto standby = place(rooms_, scene.cost, draws_.bits(), rack_of(scene.owner));
  if (!standby || !scene.at_owner.serving) return;  // rebalance() tries again
  reserve_standby(scene.at_owner, hosts_[*standby].self);
  write_record(at);
}

void VirtualFleet::name_missing_standbys() {
  for (std::uint32_t at = 0; at < scenes_.size(); ++at) {
    const Scene& scene = scenes_[at];
    const bool on_its_way = record_to_write(scene.at_owner).has_value();
    if (!hosts_[scene.owner].alive || hosts_[scene.owner].cut || scene.moving || on_its_way)
      continue;
    if (scene.standby == kNobody || rooms_[scene.standby].draining) name_standby(at);
  }
}

void VirtualFleet::lose(std::uint32_t at, double until_noticed) {
  Hand& hand = hands_[at];
  if (std::exchange(hand.waiting, true)) return;
  hand.lost = now_;
  hand.attempts = 0;
  hand.known.session.reset();
  ++outside_;
  this->at(now_ + until_noticed + inputs_.first_wait * draws_.uniform(),
           [this, at] { attempt(at); });
}

void VirtualFleet::retry(std::uint32_t at, double after) {
  const int doubled = static_cast<int>(std::min(hands_[at].attempts, 8u));
  const double wait = std::min(inputs_.longest_wait, std::ldexp(inputs_.first_wait, doubled));
  const double random = 1.0 - inputs_.jitter * draws_.uniform();
  this->at(now_ + after + wait * random, [this, at] { attempt(at); });
}

void VirtualFleet::attempt(std::uint32_t at) {
  Hand& hand = hands_[at];
  Scene& scene = scenes_[hand.scene];
  ++hand.attempts;
  ++counts_.attempts;
  if (reaches(hand, scene.owner)) return join(at, scene.owner);
  // The owner is silent to this hand. It knows the standby from the record that came with its
  // session, and any host that it asks redirects it there.
  if (!reaches(hand, scene.standby)) return retry(at, inputs_.attempt);
  take_over_scene(hand.scene);
  join(at, scene.owner);
}

void VirtualFleet::join(std::uint32_t at, std::uint32_t host_at) {
  Host& host = hosts_[host_at];
  const double round_trip = inputs_.round_trip.draw(draws_);
  const double arrives = now_ + 1.5 * round_trip;
  const Scene& scene = scenes_[hands_[at].scene];
  if (arrives < scene.ready) return retry(at, round_trip);  // the scene is being loaded
  if (host.joins_free - arrives > inputs_.most_waiting * inputs_.join_time) {
    ++counts_.crowded_out;
    return retry(at, round_trip);
  }
  host.joins_free = std::max(host.joins_free, arrives) + inputs_.join_time;
  this->at(host.joins_free + 0.5 * round_trip, [this, at, host_at] {
    Hand& hand = hands_[at];
    const Scene& joined = scenes_[hand.scene];
    if (joined.owner != host_at || !hosts_[host_at].alive ||
        answer_join(joined.at_owner, hand.known.highest) != JoinAnswer::accepted)
      return retry(at, 0.0);
    if (!take_session(hand.known, *joined.at_owner.serving)) {
      ++counts_.lower_epochs;
      return retry(at, 0.0);
    }
    hand.waiting = false;
    --outside_;
    ++counts_.joins;
    counts_.joins_by_second.add(now_ - counted_from_, 1.0);
    counts_.last_join = now_;
    counts_.without_session.record(static_cast<std::int64_t>((now_ - hand.lost) * kMicroseconds));
  });
}

void VirtualFleet::take_over_scene(std::uint32_t at) {
  Scene& scene = scenes_[at];
  if (!take_over(scene.at_standby, hosts_[scene.standby].self)) return;
  ++counts_.takeovers;
  if (hosts_[scene.owner].alive) {  // it goes on serving the hands that it reaches
    scene.former = scene.owner;
    scene.former_core = scene.core;
    scene.at_former = scene.at_owner;
  } else {
    std::erase(hosts_[scene.owner].scenes, at);
  }
  scene.at_owner = std::exchange(scene.at_standby, {});
  const std::uint32_t host = std::exchange(scene.standby, kNobody);
  occupy(at, host, take_core(at, host));
  scene.ready = now_ + inputs_.probe + inputs_.start.draw(draws_);
  write_record(at);
}

void VirtualFleet::kill_hosts(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t host = first; host < first + count; ++host) {
    hosts_[host].alive = false;
    for (const std::uint32_t scene : hosts_[host].scenes)
      for (std::uint32_t hand = 0; hand < scenes_[scene].hands; ++hand)
        lose(scenes_[scene].first_hand + hand, inputs_.silence);
  }
  at(now_ + inputs_.aged + inputs_.heartbeat * draws_.uniform(), [this, first, count] {
    for (std::uint32_t host = first; host < first + count; ++host) rooms_[host].draining = true;
    name_missing_standbys();
  });
}

void VirtualFleet::cut_off(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t host = first; host < first + count; ++host) {
    hosts_[host].cut = true;
    for (const std::uint32_t scene : hosts_[host].scenes) {
      for (std::uint32_t hand = 0; hand < scenes_[scene].hands; ++hand) {
        const std::uint32_t at = scenes_[scene].first_hand + hand;
        hands_[at].cut = draws_.uniform() < 0.5;
        if (hands_[at].cut) lose(at, inputs_.silence);
      }
    }
  }
  at(now_ + inputs_.aged, [this, first, count] {
    for (std::uint32_t host = first; host < first + count; ++host)
      rooms_[host].draining = hosts_[host].cut;
    name_missing_standbys();
  });
}

void VirtualFleet::heal() {
  for (Host& host : hosts_) host.cut = false;
  for (std::uint32_t host = 0; host < hosts_.size(); ++host)
    if (hosts_[host].alive && !hosts_[host].drained) rooms_[host].draining = false;
  for (std::uint32_t at = 0; at < scenes_.size(); ++at) {
    const Scene& scene = scenes_[at];
    // The watch shows the former owner what it has missed; the others write what they could not.
    if (scene.former != kNobody) release_former(at, scene.at_owner.record, ++revision_);
    write_record(at);
  }
  name_missing_standbys();
}

std::optional<Move> VirtualFleet::next_move_of(std::uint32_t host, bool overfull_only) {
  std::vector<PlacedScene> placed;
  std::vector<std::uint32_t> numbers;
  for (const std::uint32_t at : hosts_[host].scenes) {
    const Scene& scene = scenes_[at];
    if (scene.moving || scene.owner != host) continue;
    if (overfull_only && !overfull(rooms_[host], scene.core)) continue;
    placed.push_back({scene.cost, scene.core});
    numbers.push_back(at);
  }
  auto move = next_move(rooms_, host, placed, draws_.bits());
  if (move) move->scene = numbers[move->scene];
  return move;
}

void VirtualFleet::move(std::uint32_t at, std::uint32_t to) {
  Scene& scene = scenes_[at];
  scene.moving = true;
  const std::uint32_t source = scene.owner;
  ++hosts_[source].moving;
  const std::size_t core = take_core(at, to);
  // The target loads the scene before it claims it; the source serves until it hears of that.
  this->at(now_ + inputs_.start.draw(draws_), [this, at, source, to, core] {
    if (hosts_[to].cut) return finish_move(at, source, to, core, std::nullopt);
    SceneOwnership target;
    see_record(target, scenes_[at].at_owner.record, revision_);
    const SceneRecord claimed = claim(target, hosts_[to].self, {});
    write(to, encode(claimed).size(), [this, at, source, to, core, target, claimed]() mutable {
      finish_claim(target, claimed, ++revision_);
      finish_move(at, source, to, core, target);
    });
  });
}

void VirtualFleet::finish_move(std::uint32_t at, std::uint32_t source, std::uint32_t to,
                               std::size_t core, const std::optional<SceneOwnership>& target) {
  Scene& scene = scenes_[at];
  scene.moving = false;
  --hosts_[source].moving;
  if (!target || scene.owner != source || hosts_[source].cut ||
      !see_record(scene.at_owner, target->record, revision_)) {
    rooms_[to].free_cores[core] += scene.cost.core_share;  // somebody else has it, or nobody may
  } else {
    for (std::uint32_t hand = scene.first_hand; hand < scene.first_hand + scene.hands; ++hand)
      if (hands_[hand].known.session) lose(hand, 0.0);
    vacate(at, source, scene.core);
    occupy(at, to, core);
    scene.at_owner = *target;
    ++counts_.moves;
    name_standby(at);
  }
  if (hosts_[source].drained) drain_further(source);
}

void VirtualFleet::drain(std::uint32_t host, std::function<void()> done) {
  hosts_[host].drained = std::move(done);
  rooms_[host].draining = true;
  name_missing_standbys();
  drain_further(host);
}

void VirtualFleet::drain_further(std::uint32_t at) {
  Host& host = hosts_[at];
  while (host.moving < kMovesAtOnce) {
    const auto next = next_move_of(at, false);
    if (!next) break;
    move(static_cast<std::uint32_t>(next->scene), static_cast<std::uint32_t>(next->to));
  }
  if (host.moving > 0) return;
  if (!host.scenes.empty()) return this->at(now_ + 1.0, [this, at] { drain_further(at); });
  this->at(now_ + inputs_.restart, [this, at] {
    hosts_[at].self.number = rooms_[at].number = ++started_;
    rooms_[at].draining = false;
    std::exchange(hosts_[at].drained, {})();
  });
}

void VirtualFleet::rebalance() {
  name_missing_standbys();
  for (std::uint32_t host = 0; host < hosts_.size(); ++host) {
    if (!hosts_[host].alive) continue;
    for (std::uint32_t moves = 0; moves < kMovesAtOnce; ++moves) {
      const auto next = next_move_of(host, true);
      if (!next) break;
      move(static_cast<std::uint32_t>(next->scene), static_cast<std::uint32_t>(next->to));
    }
  }
  if (overfull_cores() > 0) counts_.last_overfull = now_;
  at(now_ + kRebalanceEvery, [this] { rebalance(); });
}

std::uint32_t VirtualFleet::overfull_cores() const {
  std::uint32_t overfull_now = 0;
  for (std::size_t host = 0; host < rooms_.size(); ++host)
    for (std::size_t core = 0; hosts_[host].alive && core < rooms_[host].free_cores.size(); ++core)
      overfull_now += overfull(rooms_[host], core) ? 1 : 0;
  return overfull_now;
}

double VirtualFleet::highest_load() const {
  double highest = 0.0;
  for (std::size_t host = 0; host < rooms_.size(); ++host)
    if (hosts_[host].alive) highest = std::max(highest, load(rooms_[host]));
  return highest;
}

}  // namespace feltwire::fleet
