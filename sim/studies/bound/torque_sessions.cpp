// Runs whole sessions with a body as the tool: hand, servo, datagrams, link, server and back.

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/parallel.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/network_run.hpp"
#include "sim/studies/bound/torque.hpp"

namespace feltwire {
namespace {

constexpr std::array kSessionLinks = {"delay=0", "delay=25,jitter=5,order=free,loss=5,seed=7"};
constexpr std::array kSessionModes = {kSessionMethod, kDefaultMethod};
/// The local models of the client, as {local_model, whole}: none, planes, whole body and solids.
constexpr std::array kModels = {std::pair(false, false), std::pair(true, false),
                                std::pair(true, true)};

void run_session(TorqueSession& session, TorqueTask task) {
  const Hand hand = with_wrist(session.hand.hand);
  press(task, hand);
  NetworkRunOptions options;
  options.hand = {.spec = torque_device(TorqueCase{}.damping),
                  .hand = hand,
                  .task = task.hand,
                  .wrist = task.wrist};
  options.parameters.mode = session.mode;
  options.parameters.local_model = session.local_model;
  options.whole_scene = session.whole;
  options.servo = protect_hand(options.parameters);
  options.link = parse_link(session.link);
  options.duration = session.duration;
  const NetworkRunResult run = run_network(*task.scene, options);
  session.energy_made = std::max(0.0, -run.observed_port.least_margin());
  session.energy_made_true = std::max(0.0, -run.least_device_margin);
  session.violations = run.observed_port.violations();
  std::array<std::vector<double>, 3> turns;
  std::vector<double> errors;
  Vec3 last_off = Vec3::Zero();
  for (const NetworkSample& s : run.samples) {
    session.torque_rms += s.held.torque.squaredNorm();
    session.ideal_rms += s.ideal.torque.squaredNorm();
    const Vec3 off = s.held.torque - s.ideal.torque;
    session.torque_error += off.squaredNorm();
    errors.push_back(off.norm());
    session.largest_jump = std::max(session.largest_jump, (off - last_off).norm());
    last_off = off;
    const Vec3 turn = rotation_between(Quaternion::Identity(), s.orientation);
    for (std::size_t i = 0; i < turns.size(); ++i)
      turns[i].push_back(turn[static_cast<Eigen::Index>(i)]);
  }
  const auto count = static_cast<double>(run.samples.size());
  for (double* sum : {&session.torque_rms, &session.ideal_rms, &session.torque_error})
    *sum = std::sqrt(*sum / count);
  session.usual_error = median(errors);
  session.oscillation = 0.0;
  for (const auto& turn : turns)
    session.oscillation =
        std::max(session.oscillation, highpass_rms(turn, 1.0 / options.parameters.servo_period));
}

}  // namespace

std::vector<TorqueSession> torque_sessions() {
  std::vector<TorqueSession> sessions;
  for (const TorqueTask& task : body_tasks()) {
    for (const std::string_view mode : kSessionModes)
      for (const char* link : kSessionLinks)
        for (const auto& [local_model, whole] : kModels) {
          // Local models run only with kSessionMethod, because only this method renders their
          // forces unchanged.
          if (local_model && mode != kSessionMethod) continue;
          for (const NamedHand& hand : kEightHands)
            sessions.push_back({.task = task.name,
                                .mode = std::string(mode),
                                .link = link,
                                .hand = hand,
                                .local_model = local_model,
                                .whole = whole});
        }
    for (const NamedHand& hand : kEightHands)  // a reference, whose only errors are encoder errors
      sessions.push_back({.task = task.name,
                          .mode = std::string(kUnbounded),
                          .link = kSessionLinks[0],
                          .hand = hand,
                          .local_model = true,
                          .whole = true});
  }
  return sessions;
}

void run_sessions(std::vector<TorqueSession>& sessions) {
  const auto tasks = body_tasks();
  parallel_for(sessions.size(), [&](std::size_t i) {
    const auto named = [&](const TorqueTask& task) { return task.name == sessions[i].task; };
    const auto found = std::ranges::find_if(tasks, named);
    if (found == tasks.end())
      throw std::invalid_argument("torque has no task '" + sessions[i].task + "'");
    run_session(sessions[i], *found);
  });
}

}  // namespace feltwire
