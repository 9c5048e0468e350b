#include "server/scene/teleop_link.hpp"

#include <algorithm>
#include <cmath>

#include "server/scene/client_time.hpp"

namespace feltwire {
namespace {

/// Returns a contact in the frame of the hand, or no contact if its values are out of the range of
/// a reply.
RemoteContact sendable(const RemoteContact& contact) {
  constexpr double kSoftest = 1e-3, kStiffest = 1e9;  // [N/m] range of the stiffness
  constexpr double kFastest = 100.0;                  // [m/s] largest velocity on each axis
  const bool can = contact.point.cwiseAbs().maxCoeff() <= kMaxPosition &&
                   contact.velocity.cwiseAbs().maxCoeff() <= kFastest &&
                   contact.stiffness >= kSoftest && contact.stiffness <= kStiffest;
  return can ? contact : RemoteContact{};
}
EnergyCounters sendable(const EnergyCounters& energy) {
  const bool can =
      std::isfinite(energy.given) && std::isfinite(energy.taken) && std::isfinite(energy.pushed);
  return can ? energy : EnergyCounters{};
}

constexpr double kMostWork = 1e3;  // [J] largest possible work of a hand between two samples

}  // namespace

void TeleopLink::seat_robot(std::uint32_t robot, const Workspace& own) noexcept {
  robot_ = robot;
  limit_ = WorkspaceLimit(joined(seat_.workspace, own));
  robot_state_ = {};
  targets_ = 0;
  fresh_ = answers_ = false;
}

void TeleopLink::leave(std::uint32_t number) noexcept {
  Leader* const leader = seat_of(number);
  if (leader != nullptr) *leader = {};
  stop_waiting(number);
  if (number == robot_) {
    robot_ = 0;
    for (Leader& l : leaders_) l.engagement.step({});
  }
  if (leader != nullptr) fresh_ = true;
  regroup();
  fresh_ = fresh_ && robot_ != 0;
}

TeleopLink::Leader* TeleopLink::seat_of(std::uint32_t hand) noexcept {
  if (hand == 0) return nullptr;
  const auto found = std::ranges::find(leaders_, hand, &Leader::hand);
  return found != leaders_.end() ? &*found : nullptr;
}

/// Checks whether the hand moved faster than kJump times the speed limit. The time is that of the
/// hand's clock, but at least the nominal time between the two samples.
bool TeleopLink::jumped(const Leader& leader, const Sample& sample, double period) const noexcept {
  if (leader.sample.index == 0) return false;
  const double nominal = period * static_cast<double>(sample.index - leader.sample.index);
  const double elapsed =
      std::max(nominal, seconds_between(leader.sample.client_time, sample.client_time));
  const double way = (sample.pose.position - leader.sample.pose.position).norm();
  return !(way <= kJump * seat_.speed / seat_.scale * elapsed);
}

/// Stores the switch state of a hand that waits for the lead. Returns true if the hand presses the
/// switch now and had released it in its previous sample.
bool TeleopLink::requests_lead(std::uint32_t hand, bool pressed) noexcept {
  auto waiting = std::ranges::find(waiting_, hand, &Waiting::hand);
  if (waiting == waiting_.end()) waiting = std::ranges::find(waiting_, 0u, &Waiting::hand);
  if (waiting == waiting_.end()) return false;
  const bool presses = pressed && waiting->hand == hand && waiting->released;
  *waiting = {hand, !pressed};
  return presses;
}

void TeleopLink::stop_waiting(std::uint32_t hand) noexcept {
  std::ranges::replace_if(
      waiting_, [&](const Waiting& w) { return w.hand == hand; }, Waiting{});
}

/// Makes a waiting hand the only leader. The first step() sees a released switch, because the hand
/// has released it while it waited. So the next press engages the hand.
TeleopLink::Leader* TeleopLink::transfer_lead(std::uint32_t hand, double share,
                                              const Sample& newest, Nanoseconds now) noexcept {
  stop_waiting(hand);
  leaders_ = {};
  Leader& leader = leaders_.front();
  leader.hand = hand;
  leader.share = share;
  leader.sample = newest;
  leader.heard = now;
  step(leader, false, now);
  leader.sample.index = 0;  // so lead() ignores the samples before the transfer
  return &leader;
}

bool TeleopLink::others_lead(const Leader& leader) const noexcept {
  return std::ranges::any_of(leaders_,
                             [&](const Leader& l) { return l.hand != 0 && &l != &leader; });
}

/// Adds a hand that wants to lead to leaders_. Returns null if it cannot lead now.
TeleopLink::Leader* TeleopLink::admit(std::uint32_t hand, double share, const Sample& newest,
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
  if (!requests_lead(hand, pressed) || led) return nullptr;
  return transfer_lead(hand, share, newest, now);
}

void TeleopLink::lead(std::uint32_t hand, const SampleBatch& batch, double period, Nanoseconds now,
                      double share) noexcept {
  const Sample& newest = batch.samples[0];
  Leader* leader = seat_of(hand);
  if (leader != nullptr && share == 0.0 && others_lead(*leader)) {
    leave(hand);
    leader = nullptr;
  }
  if (leader == nullptr) leader = admit(hand, share, newest, batch.lead->deadman, now);
  if (leader == nullptr) return;
  const auto which = static_cast<std::size_t>(leader - leaders_.data());
  const bool refused = jumped(*leader, newest, period);
  const double paid =
      leader->sample.index != 0 ? batch.lead->hand_work - leader->lead.hand_work : 0.0;
  // Ignore more work than a hand can do between two samples.
  if (std::abs(paid) < kMostWork) work_ += clutch_.clutch(which).at_robot(paid);
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
  if (seat_.aligned) clutch_.align(which, seat_.aligned->offset, Alignment::kGivenBack * turning);
  if (leader->engaged()) move(which);
  fresh_ = true;
}

/// If the engaged hands or their weights have changed, starts the shared lead again from their
/// present poses and the present target, so that the target does not jump.
void TeleopLink::regroup() noexcept {
  std::array<double, kMostLeaders> weights{};
  SharedClutchOffset::Parts parts;
  for (std::size_t i = 0; i < kMostLeaders; ++i) {
    const Leader& l = leaders_[i];
    if (!l.engaged()) continue;
    weights[i] = l.share > 0.0 ? l.share : 1.0;
    parts[i] = {weights[i], l.robot_pose()};
  }
  if (weights == grouped_) return;
  const bool nobody_led = grouped_ == std::array<double, kMostLeaders>{};
  grouped_ = weights;
  if (nobody_led) {
    wanted_ = robot_state_.commanded;
    limit_.begin(wanted_);
  }
  clutch_.begin(parts, wanted_);
}

/// Moves the target wanted_ to the pose that a leading hand commands, within the workspace.
void TeleopLink::move(std::size_t leader) noexcept {
  const Pose before = wanted_;
  const Pose asked = clutch_.asked(leader, leaders_[leader].robot_pose(), before);
  wanted_ = limit_.keep(asked);
  clutch_.settle(leader, wanted_.position - before.position,
                 limit_.free_part(wanted_.position - asked.position));
}

bool TeleopLink::follow(const RobotState& state, Nanoseconds now) noexcept {
  if (state.index <= robot_state_.index) return false;
  robot_state_ = state;
  robot_time_ = now;
  answers_ = true;
  for (Leader& leader : leaders_)
    if (leader.hand != 0) step(leader, false, now);
  regroup();
  return true;
}

void TeleopLink::step(Leader& leader, bool refused, Nanoseconds now) noexcept {
  const LinkState before = leader.engagement.state();
  leader.engagement.step(
      {.seated = robot_ != 0 && robot_state_.index != 0 && leader.sample.index != 0,
       .robot_well = now - robot_time_ <= kSilence && robot_state_.ok && !robot_state_.stopped,
       .hand_silent = leader.silent(now),
       .refused = refused,
       .deadman = leader.deadman.pressed(),
       .wrench_above = robot_state_.force && robot_state_.force->norm() > seat_.force,
       .aligned = !seat_.aligned || turn_missing(leader).norm() <= seat_.aligned->gate});
  fresh_ |= leader.engagement.state() != before;
}

LinkState TeleopLink::state() const noexcept {
  using enum LinkState;
  for (const LinkState s : {engaged, clutched, hold, ready, aligning, fault})
    for (const Leader& l : leaders_)
      if (l.hand != 0 && l.engagement.state() == s) return s;
  return disabled;
}

/// Returns the index of the engaged leader that turns the robot. If no leader is engaged, returns
/// the index of the first leader.
std::size_t TeleopLink::first() const noexcept {
  if (clutch_.turns() < kMostLeaders && leaders_[clutch_.turns()].engaged()) return clutch_.turns();
  for (std::size_t i = 0; i < kMostLeaders; ++i)
    if (leaders_[i].hand != 0) return i;
  return 0;
}

bool TeleopLink::engages(std::uint32_t hand) const noexcept {
  return std::ranges::any_of(leaders_,
                             [&](const Leader& l) { return l.hand == hand && l.engaged(); });
}

Remote TeleopLink::reply_for(std::uint32_t hand, Nanoseconds now) const noexcept {
  const auto leader = std::ranges::find(leaders_, hand, &Leader::hand);
  if (hand == 0 || leader == leaders_.end() || robot_state_.index == 0) return {};
  // Each hand gets its share of the energy at the robot. The hand's own scale contains the same
  // share, and both cancel. So use the scale of the seat.
  Remote remote{
      .state = leader->engagement.state(),
      .pose = robot_state_.pose,
      .contact = {},
      .energy = sendable(ClutchOffset(seat_.scale, seat_.force_scale).at_hand(robot_state_.energy)),
      .gripper = robot_state_.gripper,
      .gripper_force = robot_state_.gripper_force,
      .age = std::max(0.0, seconds(now - robot_time_))};
  // A contact can be converted to the hand's frame only while the hand is engaged.
  if (!leader->engaged()) {
    if (seat_.aligned && leader->sample.index != 0) remote.turn = turn_missing(*leader);
    return remote;
  }
  const auto which = static_cast<std::size_t>(leader - leaders_.begin());
  remote.meets_surfaces = which == clutch_.turns();
  const ClutchOffset& clutch = clutch_.clutch(which);
  const auto at_hand = [&](const RemoteContact& surface) {
    return sendable(clutch.at_hand(limit_.free_part(surface)));
  };
  remote.contact = at_hand(robot_state_.contact);
  for (const RemoteContact& other : robot_state_.others.view()) {
    const RemoteContact surface = at_hand(other);
    if (surface.surface != 0)
      remote.others.surfaces[static_cast<std::size_t>(remote.others.count++)] = surface;
  }
  add_walls(remote, clutch);
  return remote;
}

/// Adds the walls of the workspace nearest to the target, the nearest first.
void TeleopLink::add_walls(Remote& remote, const ClutchOffset& clutch) const noexcept {
  std::array<double, kMostRemoteWalls> nearest{};
  const auto walls = limit_.walls();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const double clearance = walls[i].clearance(wanted_.position);
    if (!(clearance < kWallRange)) continue;
    const WorkspaceWall wall = clutch.at_hand(walls[i]);
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

std::optional<SeenRobot> TeleopLink::view(Nanoseconds now) const noexcept {
  if (!visible()) return std::nullopt;
  return SeenRobot{.pose = robot_state_.pose,
                   .target = robot_state_.commanded,
                   .force = robot_state_.force,
                   .torque = robot_state_.torque,
                   .state = state(),
                   .hand = leaders_[first()].hand,
                   .ok = robot_state_.ok,
                   .stopped = robot_state_.stopped,
                   .touches = robot_state_.contact.touching,
                   .gripper = robot_state_.gripper,
                   .age = std::max(0.0, seconds(now - robot_time_))};
}

/// Returns the smallest Lead::known_surface of the engaged hands. If no hand is engaged, returns
/// that of the first leader.
std::uint32_t TeleopLink::known_surface() const noexcept {
  std::uint32_t known = leaders_[first()].lead.known_surface;
  for (const Leader& l : leaders_)
    if (l.engaged()) known = std::min(known, l.lead.known_surface);
  return known;
}

/// Returns the gripper opening [m] of the engaged hand with the largest share among those that have
/// a gripper lever; < 0: no engaged hand has one.
double TeleopLink::gripper() const noexcept {
  double opening = -1.0, largest = 0.0;
  for (std::size_t i = 0; i < kMostLeaders; ++i) {
    const Leader& l = leaders_[i];
    if (!l.engaged() || !(l.lead.gripper >= 0.0) || !(clutch_.share(i) > largest)) continue;
    opening = l.lead.gripper;
    largest = clutch_.share(i);
  }
  return opening;
}

RobotTarget TeleopLink::target(Nanoseconds now) noexcept {
  fresh_ = answers_ = false;
  sent_at_ = now;
  const LinkState now_is = state();
  const bool engaged = now_is == LinkState::engaged;
  return {.index = ++targets_,
          .sample_index = leaders_[first()].sample.index,
          .state = now_is,
          .pose = engaged ? wanted_ : robot_state_.commanded,
          .gripper = gripper(),
          .known_surface = known_surface(),
          .hand_work = work_};
}

}  // namespace feltwire
