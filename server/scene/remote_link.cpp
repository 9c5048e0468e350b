#include "server/scene/remote_link.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

/// [s] between two times of a possibly hostile clock. The difference wraps around, never overflows.
double time_between(Nanoseconds earlier, Nanoseconds later) {
  const auto difference =
      static_cast<std::uint64_t>(later.count()) - static_cast<std::uint64_t>(earlier.count());
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(difference));
}

/// If a robot's contact, in the hand's measure, does not fit into a reply, it counts as none.
RemoteContact tellable(const RemoteContact& contact) {
  constexpr double kSoftest = 1e-3, kStiffest = 1e9;  // [N/m]
  constexpr double kFastest = 100.0;                  // [m/s]
  const bool can = contact.point.cwiseAbs().maxCoeff() <= kMaxPosition &&
                   contact.velocity.cwiseAbs().maxCoeff() <= kFastest &&
                   contact.stiffness >= kSoftest && contact.stiffness <= kStiffest;
  return can ? contact : RemoteContact{};
}
EnergyCounters tellable(const EnergyCounters& energy) {
  const bool can =
      std::isfinite(energy.given) && std::isfinite(energy.taken) && std::isfinite(energy.pushed);
  return can ? energy : EnergyCounters{};
}

constexpr double kMostWork = 1e3;  // [J]

}  // namespace

void RemoteLink::sit(std::uint32_t robot, const Workspace& own) noexcept {
  robot_ = robot;
  limit_ = WorkspaceLimit(joined(seat_.workspace, own));
  said_ = {};
  targets_ = 0;
  fresh_ = answers_ = false;
}

void RemoteLink::leave(std::uint32_t number) noexcept {
  Leader* const leader = seat_of(number);
  if (leader != nullptr) *leader = {};
  stop_waiting(number);
  if (number == robot_) {
    robot_ = 0;
    for (Leader& l : leaders_) l.authority.step({});
  }
  if (leader != nullptr) fresh_ = true;
  regroup();
  fresh_ = fresh_ && robot_ != 0;
}

RemoteLink::Leader* RemoteLink::seat_of(std::uint32_t hand) noexcept {
  if (hand == 0) return nullptr;
  const auto found = std::ranges::find(leaders_, hand, &Leader::hand);
  return found != leaders_.end() ? &*found : nullptr;
}

/// Uses the hand's clock, but at least the nominal time of its samples.
bool RemoteLink::jumped(const Leader& leader, const Sample& sample, double period) const noexcept {
  if (leader.sample.index == 0) return false;
  const double nominal = period * static_cast<double>(sample.index - leader.sample.index);
  const double elapsed =
      std::max(nominal, time_between(leader.sample.client_time, sample.client_time));
  const double way = (sample.pose.position - leader.sample.pose.position).norm();
  return !(way <= kJump * seat_.speed / seat_.scale * elapsed);
}

/// Whether a waiting hand presses its switch now. A switch that is held down is no request.
bool RemoteLink::asks(std::uint32_t hand, bool pressed) noexcept {
  auto waiting = std::ranges::find(waiting_, hand, &Waiting::hand);
  if (waiting == waiting_.end()) waiting = std::ranges::find(waiting_, 0u, &Waiting::hand);
  if (waiting == waiting_.end()) return false;
  const bool presses = pressed && waiting->hand == hand && waiting->released;
  *waiting = {hand, !pressed};
  return presses;
}

void RemoteLink::stop_waiting(std::uint32_t hand) noexcept {
  std::ranges::replace_if(
      waiting_, [&](const Waiting& w) { return w.hand == hand; }, Waiting{});
}

/// Hands the lead to a hand that has shown a released switch, so its switch is armed.
RemoteLink::Leader* RemoteLink::hand_over(std::uint32_t hand, double share, const Sample& newest,
                                          Nanoseconds now) noexcept {
  stop_waiting(hand);
  leaders_ = {};
  Leader& leader = leaders_.front();
  leader.hand = hand;
  leader.share = share;
  leader.sample = newest;
  leader.heard = now;
  step(leader, false, now);
  leader.sample.index = 0;  // ignore everything that it sent before
  return &leader;
}

bool RemoteLink::others_sit(const Leader& leader) const noexcept {
  return std::ranges::any_of(leaders_,
                             [&](const Leader& l) { return l.hand != 0 && &l != &leader; });
}

/// Seats a hand that wants to lead; null: it cannot now.
RemoteLink::Leader* RemoteLink::let_in(std::uint32_t hand, double share, const Sample& newest,
                                       bool pressed, Nanoseconds now) noexcept {
  const auto sits = [](const Leader& l) { return l.hand != 0; };
  const bool alone = std::ranges::none_of(leaders_, sits);
  const bool together = share > 0.0 && std::ranges::all_of(leaders_, [&](const Leader& l) {
                          return !sits(l) || l.share > 0.0;
                        });
  if (alone || together) {
    const auto seat = std::ranges::find_if(
        leaders_, [&](const Leader& l) { return !sits(l) || (!alone && l.silent(now)); });
    if (seat == leaders_.end()) return nullptr;
    stop_waiting(hand);
    *seat = {};
    seat->hand = hand;
    seat->share = share;
    return &*seat;
  }
  const bool led = std::ranges::any_of(
      leaders_, [&](const Leader& l) { return sits(l) && l.deadman.pressed() && !l.silent(now); });
  if (!asks(hand, pressed) || led) return nullptr;
  return hand_over(hand, share, newest, now);
}

void RemoteLink::lead(std::uint32_t hand, const SampleBatch& batch, double period, Nanoseconds now,
                      double share) noexcept {
  const Sample& newest = batch.samples[0];
  Leader* leader = seat_of(hand);
  if (leader != nullptr && share == 0.0 && others_sit(*leader)) {
    leave(hand);
    leader = nullptr;
  }
  if (leader == nullptr) leader = let_in(hand, share, newest, batch.lead->deadman, now);
  if (leader == nullptr) return;
  const auto which = static_cast<std::size_t>(leader - leaders_.data());
  const bool refused = jumped(*leader, newest, period);
  const double paid =
      leader->sample.index != 0 ? batch.lead->hand_work - leader->lead.hand_work : 0.0;
  // No hand can do more work between two samples.
  if (std::abs(paid) < kMostWork) work_ += index_.index(which).at_robot(paid);
  const double turning =
      seat_.aligned && leader->engaged()
          ? rotation_between(leader->sample.pose.orientation, newest.pose.orientation).norm()
          : 0.0;
  leader->share = share;
  leader->sample = newest;
  leader->lead = *batch.lead;
  leader->deadman.step(batch.lead->deadman, now);
  leader->heard = now;
  step(*leader, refused, now);
  regroup();
  if (seat_.aligned) index_.align(which, seat_.aligned->offset, Alignment::kGivenBack * turning);
  if (leader->engaged()) move(which);
  fresh_ = true;
}

/// The engaged hands lead together, starting from their present poses and the target.
void RemoteLink::regroup() noexcept {
  std::array<double, kMostLeaders> weights{};
  SharedIndex::Parts parts;
  for (std::size_t i = 0; i < kMostLeaders; ++i) {
    const Leader& l = leaders_[i];
    if (!l.engaged()) continue;
    weights[i] = l.share > 0.0 ? l.share : 1.0;
    parts[i] = {weights[i], l.meant()};
  }
  if (weights == grouped_) return;
  const bool nobody_led = grouped_ == std::array<double, kMostLeaders>{};
  grouped_ = weights;
  if (nobody_led) {
    wanted_ = said_.commanded;
    limit_.begin(wanted_);
  }
  index_.begin(parts, wanted_);
}

/// Moves the target to the pose that a leading hand asks for.
void RemoteLink::move(std::size_t leader) noexcept {
  const Pose before = wanted_;
  const Pose asked = index_.asked(leader, leaders_[leader].meant(), before);
  wanted_ = limit_.keep(asked);
  index_.settle(leader, wanted_.position - before.position,
                limit_.free_part(wanted_.position - asked.position));
}

bool RemoteLink::follow(const RobotState& state, Nanoseconds now) noexcept {
  if (state.index <= said_.index) return false;
  said_ = state;
  robot_heard_ = now;
  answers_ = true;
  for (Leader& leader : leaders_)
    if (leader.hand != 0) step(leader, false, now);
  regroup();
  return true;
}

void RemoteLink::step(Leader& leader, bool refused, Nanoseconds now) noexcept {
  const LinkState before = leader.authority.state();
  leader.authority.step(
      {.seated = robot_ != 0 && said_.index != 0 && leader.sample.index != 0,
       .robot_well = now - robot_heard_ <= kSilence && said_.ok && !said_.stopped,
       .hand_silent = leader.silent(now),
       .refused = refused,
       .deadman = leader.deadman.pressed(),
       .wrench_above = said_.force && said_.force->norm() > seat_.force,
       .aligned = !seat_.aligned || turn_missing(leader).norm() <= seat_.aligned->gate});
  fresh_ |= leader.authority.state() != before;
}

LinkState RemoteLink::state() const noexcept {
  using enum LinkState;
  for (const LinkState s : {engaged, clutched, hold, ready, aligning, fault})
    for (const Leader& l : leaders_)
      if (l.hand != 0 && l.authority.state() == s) return s;
  return disabled;
}

/// The leader that turns the robot. If nobody is engaged, the first leader with a seat.
std::size_t RemoteLink::first() const noexcept {
  if (index_.turns() < kMostLeaders && leaders_[index_.turns()].engaged()) return index_.turns();
  for (std::size_t i = 0; i < kMostLeaders; ++i)
    if (leaders_[i].hand != 0) return i;
  return 0;
}

bool RemoteLink::engages(std::uint32_t hand) const noexcept {
  return std::ranges::any_of(leaders_,
                             [&](const Leader& l) { return l.hand == hand && l.engaged(); });
}

Remote RemoteLink::told(std::uint32_t hand, Nanoseconds now) const noexcept {
  const auto leader = std::ranges::find(leaders_, hand, &Leader::hand);
  if (hand == 0 || leader == leaders_.end() || said_.index == 0) return {};
  // Each hand gets its share of the environment's energy. Its own scale cancels the share.
  Remote remote{
      .state = leader->authority.state(),
      .pose = said_.pose,
      .contact = {},
      .energy = tellable(EngageIndex(seat_.scale, seat_.force_scale).at_hand(said_.energy)),
      .gripper = said_.gripper,
      .gripper_force = said_.gripper_force,
      .age = std::max(0.0, seconds(now - robot_heard_))};
  // The contact of the hand is known only while hand and robot are engaged.
  if (!leader->engaged()) {
    if (seat_.aligned && leader->sample.index != 0) remote.turn = turn_missing(*leader);
    return remote;
  }
  const auto which = static_cast<std::size_t>(leader - leaders_.begin());
  remote.meets_surfaces = which == index_.turns();
  const EngageIndex& index = index_.index(which);
  const auto at_hand = [&](const RemoteContact& surface) {
    return tellable(index.at_hand(limit_.free_part(surface)));
  };
  remote.contact = at_hand(said_.contact);
  for (const RemoteContact& other : said_.others.view()) {
    const RemoteContact told = at_hand(other);
    if (told.surface != 0)
      remote.others.surfaces[static_cast<std::size_t>(remote.others.count++)] = told;
  }
  tell_walls(remote, index);
  return remote;
}

/// Adds the walls nearest to the target, by rising distance.
void RemoteLink::tell_walls(Remote& remote, const EngageIndex& index) const noexcept {
  std::array<double, kMostRemoteWalls> nearest{};
  const auto walls = limit_.walls();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const double clearance = walls[i].clearance(wanted_.position);
    if (!(clearance < kToldWall)) continue;
    const WorkspaceWall wall = index.at_hand(walls[i]);
    if (!(std::abs(wall.distance) <= kMaxPosition)) continue;
    int at = remote.wall_count;
    while (at > 0 && clearance < nearest[static_cast<std::size_t>(at) - 1]) --at;
    if (at == kMostRemoteWalls) continue;
    remote.wall_count = std::min(remote.wall_count + 1, kMostRemoteWalls);
    for (auto n = static_cast<std::size_t>(remote.wall_count) - 1; n > static_cast<std::size_t>(at);
         --n) {
      remote.walls[n] = remote.walls[n - 1];
      nearest[n] = nearest[n - 1];
    }
    nearest[static_cast<std::size_t>(at)] = clearance;
    remote.walls[static_cast<std::size_t>(at)] = {wall, seat_.wall_stiffness, seat_.wall_depth,
                                                  static_cast<std::uint32_t>(i)};
  }
}

std::optional<SeenRobot> RemoteLink::seen(Nanoseconds now) const noexcept {
  if (!visible()) return std::nullopt;
  return SeenRobot{.pose = said_.pose,
                   .target = said_.commanded,
                   .force = said_.force,
                   .torque = said_.torque,
                   .state = state(),
                   .hand = leaders_[first()].hand,
                   .ok = said_.ok,
                   .stopped = said_.stopped,
                   .touches = said_.contact.touching,
                   .gripper = said_.gripper,
                   .age = std::max(0.0, seconds(now - robot_heard_))};
}

/// The greatest surface number that all leading hands know; 0: none.
std::uint32_t RemoteLink::known_surface() const noexcept {
  std::uint32_t known = leaders_[first()].lead.known_surface;
  for (const Leader& l : leaders_)
    if (l.engaged()) known = std::min(known, l.lead.known_surface);
  return known;
}

/// [m] opening that the engaged hand with a lever and the largest share asks for; < 0: no lever.
double RemoteLink::gripper() const noexcept {
  double opening = -1.0, largest = 0.0;
  for (std::size_t i = 0; i < kMostLeaders; ++i) {
    const Leader& l = leaders_[i];
    if (!l.engaged() || !(l.lead.gripper >= 0.0) || !(index_.share(i) > largest)) continue;
    opening = l.lead.gripper;
    largest = index_.share(i);
  }
  return opening;
}

RobotTarget RemoteLink::target(Nanoseconds now) noexcept {
  fresh_ = answers_ = false;
  sent_at_ = now;
  const LinkState now_is = state();
  const bool engaged = now_is == LinkState::engaged;
  return {.index = ++targets_,
          .sample_index = leaders_[first()].sample.index,
          .state = now_is,
          .pose = engaged ? wanted_ : said_.commanded,
          .gripper = gripper(),
          .known_surface = known_surface(),
          .hand_work = work_};
}

}  // namespace feltwire
