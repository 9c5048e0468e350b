#include "server/scene/remote_link.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

/// [s] between two times of a clock that may be hostile: the difference of any two wraps round.
double time_between(Nanoseconds earlier, Nanoseconds later) {
  const auto difference =
      static_cast<std::uint64_t>(later.count()) - static_cast<std::uint64_t>(earlier.count());
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(difference));
}

/// A robot may say what, in the measure of the hand, no reply can carry: then there is no contact.
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
  if (number == robot_) robot_ = 0;
  if (number == hand_) {
    hand_ = 0;
    sample_.index = 0;
    lead_ = {};
  }
  stop_waiting(number);
  if (robot_ == 0 || hand_ == 0) {
    authority_.step({});
    fresh_ = robot_ != 0;
  }
}

/// By the hand's clock, and no time shorter than its samples say.
bool RemoteLink::jumped(const Sample& sample, double period) const noexcept {
  if (sample_.index == 0) return false;
  const double nominal = period * static_cast<double>(sample.index - sample_.index);
  const double elapsed = std::max(nominal, time_between(sample_.client_time, sample.client_time));
  const double way = (sample.pose.position - sample_.pose.position).norm();
  return !(way <= kJump * seat_.speed / seat_.scale * elapsed);
}

/// Whether a hand that waits presses its switch now. A switch that is only held down asks nothing.
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

/// To a hand that showed a released switch: it is armed.
void RemoteLink::hand_over(std::uint32_t hand, const Sample& newest, Nanoseconds now) noexcept {
  stop_waiting(hand);
  hand_ = hand;
  sample_ = newest;
  hand_heard_ = now;
  lead_.deadman = false;
  step(false, now);
  sample_.index = 0;  // nothing of another hand counts
}

void RemoteLink::lead(std::uint32_t hand, const SampleBatch& batch, double period,
                      Nanoseconds now) noexcept {
  const Sample& newest = batch.samples[0];
  if (hand_ == 0) {
    hand_ = hand;
    stop_waiting(hand);
  }
  if (hand != hand_) {
    const bool led = lead_.deadman && now - hand_heard_ <= kSilence;
    if (!asks(hand, batch.lead->deadman) || led) return;
    hand_over(hand, newest, now);
  }
  const bool refused = jumped(newest, period);
  const double paid = sample_.index != 0 ? batch.lead->hand_work - lead_.hand_work : 0.0;
  if (std::abs(paid) < kMostWork) work_ += paid;  // no hand pays as much from sample to sample
  sample_ = newest;
  lead_ = *batch.lead;
  hand_heard_ = now;
  const bool was_engaged = state() == LinkState::engaged;
  step(refused, now);
  if (state() == LinkState::engaged) {
    const Pose hand_pose{newest.pose.position - lead_.offset, newest.pose.orientation};
    if (!was_engaged) {
      index_.engage(hand_pose, said_.commanded);
      limit_.begin(said_.commanded);
    }
    const Pose asked = index_.target(hand_pose);
    wanted_ = limit_.keep(asked);
    index_.shift(limit_.free_part(wanted_.position - asked.position));
  }
  fresh_ = true;
}

bool RemoteLink::follow(const RobotState& state, Nanoseconds now) noexcept {
  if (state.index <= said_.index) return false;
  said_ = state;
  robot_heard_ = now;
  answers_ = true;
  step(false, now);
  return true;
}

void RemoteLink::step(bool refused, Nanoseconds now) noexcept {
  const LinkState before = state();
  authority_.step({.seated = robot_ != 0 && said_.index != 0 && sample_.index != 0,
                   .robot_well = now - robot_heard_ <= kSilence && said_.ok && !said_.stopped,
                   .hand_silent = now - hand_heard_ > kSilence,
                   .refused = refused,
                   .deadman = lead_.deadman,
                   .wrench_above = said_.force && said_.force->norm() > seat_.force});
  fresh_ |= state() != before;
}

Remote RemoteLink::told(std::uint32_t hand, Nanoseconds now) const noexcept {
  if (hand != hand_ || said_.index == 0) return {};
  Remote remote{.state = state(),
                .pose = said_.pose,
                .contact = {},
                .energy = tellable(index_.at_hand(said_.energy)),
                .gripper = said_.gripper,
                .gripper_force = said_.gripper_force,
                .age = std::max(0.0, seconds(now - robot_heard_))};
  // What the hand meets is known only where both are tied together.
  if (state() != LinkState::engaged) return remote;
  remote.contact = tellable(index_.at_hand(limit_.free_part(said_.contact)));
  tell_walls(remote);
  return remote;
}

/// Those that are nearest to the target, by rising distance.
void RemoteLink::tell_walls(Remote& remote) const noexcept {
  std::array<double, kMostRemoteWalls> nearest{};
  const auto walls = limit_.walls();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const double clearance = walls[i].clearance(wanted_.position);
    if (!(clearance < kToldWall)) continue;
    const WorkspaceWall wall = index_.at_hand(walls[i]);
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
  if (robot_ == 0 || said_.index == 0) return std::nullopt;
  return SeenRobot{.pose = said_.pose,
                   .target = said_.commanded,
                   .force = said_.force,
                   .torque = said_.torque,
                   .state = state(),
                   .hand = hand_,
                   .ok = said_.ok,
                   .stopped = said_.stopped,
                   .touches = said_.contact.touching,
                   .gripper = said_.gripper,
                   .age = std::max(0.0, seconds(now - robot_heard_))};
}

RobotTarget RemoteLink::target(Nanoseconds now) noexcept {
  fresh_ = answers_ = false;
  sent_at_ = now;
  const bool engaged = state() == LinkState::engaged;
  return {.index = ++targets_,
          .sample_index = sample_.index,
          .state = state(),
          .pose = engaged ? wanted_ : said_.commanded,
          .gripper = engaged ? lead_.gripper : -1.0,
          .known_surface = lead_.known_surface,
          .hand_work = index_.at_robot(work_)};
}

}  // namespace feltwire
