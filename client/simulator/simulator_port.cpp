#include "client/simulator/simulator_port.hpp"

#include <algorithm>
#include <utility>

#include "core/base/numeric.hpp"
#include "protocol/wire/guard.hpp"

namespace feltwire {
namespace {

constexpr double kLeastReach = 0.05;  // [m] of the plane that stands for a force

/// Moves what the surfaces have moved since the simulator saw them.
void move_on(LocalModel& model, double time) noexcept {
  for (int i = 0; i < model.count; ++i) {
    SurfacePatch& patch = model.patches[static_cast<std::size_t>(i)];
    patch.point += time * patch.velocity;
    patch.anchor = patch.point;
  }
}

}  // namespace

SimulatorPort::SimulatorPort(std::uint64_t session, const SessionKeys& keys,
                             std::shared_ptr<SimulatorFeed> feed, Clock clock)
    : session_(session),
      feed_(std::move(feed)),
      clock_(clock),
      opener_(keys.suite, keys.up),
      sealer_(keys.suite, keys.down) {}

void SimulatorPort::send(Bytes datagram) noexcept {
  ++statistics_.sent;
  const Guarded guarded = guard(datagram, set_of({DatagramKind::samples}));
  if (guarded.drop != DropReason::none || guarded.header.session != session_) return;
  const Opened opened = opener_.open(guarded.header, datagram, opened_);
  if (opened.drop != DropReason::none) return;
  if (decode(opened.payload, batch_) != DropReason::none) return;
  const Sample& sample = batch_.samples.front();
  if (sample.index <= newest_.index) return;
  newest_ = sample;
  poses_[pose_count_++ % kPoses] = {sample.client_time, sample.pose.position};
  if (waiting_) feed_->signal();
}

std::optional<Bytes> SimulatorPort::receive() noexcept {
  SimulatorContact contact;
  if (feed_->take(contact)) waiting_ = contact;
  if (!waiting_ || newest_.index <= answered_) return std::nullopt;
  const Bytes payload = encoder_.reply(answer(*waiting_));
  waiting_.reset();
  ++statistics_.received;
  return sealer_.seal(DatagramKind::reply, session_, payload, sealed_);
}

/// Returns the newest pose that is not newer than `time`, or the oldest that is known.
/// Precondition: there was a sample.
const SimulatorPort::Seen& SimulatorPort::seen_at(Nanoseconds time) const noexcept {
  const std::uint64_t kept = std::min<std::uint64_t>(pose_count_, kPoses);
  std::uint64_t first = pose_count_ - kept, last = pose_count_ - 1;
  while (first < last) {
    const std::uint64_t middle = last - (last - first) / 2;
    if (poses_[middle % kPoses].time <= time)
      first = middle;
    else
      last = middle - 1;
  }
  return poses_[first % kPoses];
}

Reply SimulatorPort::answer(SimulatorContact contact) noexcept {
  const Seen& seen = seen_at(contact.seen);
  // The hand takes the middle between its sample and this answer for the time of the contact.
  const Nanoseconds middle =
      newest_.client_time + std::max(Nanoseconds{0}, clock_() - newest_.client_time) / 2;
  const double since = std::max(0.0, seconds(middle - seen.time));
  if (!contact.modelled && contact.stiffness > 0.0 && length(contact.command.force()) > 0.0) {
    contact.model =
        plane_of(seen.position, contact.command.force(), contact.stiffness, kLeastReach);
    contact.modelled = true;
  }
  answered_ = newest_.index;
  ++answers_;
  Reply reply;
  reply.sample_index = newest_.index;
  reply.client_time = newest_.client_time;
  reply.server_times.received = reply.server_times.sent = middle;
  reply.rotation = batch_.rotation;
  reply.withheld = pose_count_ - answers_;
  reply.command = contact.command;
  if (!contact.modelled) return reply;
  contact.model.center = seen.position;
  move_on(contact.model, since);
  reply.modelled = true;
  reply.model = contact.model;
  // The hand gets the model's force. Where it leaves the model's reach, it gets this force instead.
  contact_.take(contact.model);
  const LocalForce force =
      contact_.touch({newest_.pose.position, Vec3::Zero()}, 0.0, std::max(since, 1e-3));
  reply.command.elastic = force.weight * force.command.elastic;
  reply.command.frictional = force.weight * force.command.frictional;
  reply.normals = pushing_normals(contact.model, newest_.pose.position);
  return reply;
}

}  // namespace feltwire
