#include "sim/studies/network/trade_network.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.hpp"
#include "core/base/text.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire {
namespace {

constexpr double kBegin = 1.0;  // [s] duration of the approach of the hand, which is not measured
constexpr double kClearance = 0.03;    // [m] start height, so that a reply comes before contact
constexpr double kTrafficBall = 0.09;  // [m] radius of the ball

struct TradeTask {
  double stiffness;  // [N/m]
  double friction = 0.0;
  bool ball = false;
  HandPath path = HandPath::slide;
};
constexpr std::array<TradeTask, 3> kTrafficTasks = {
    {{.stiffness = 1000.0, .ball = true, .path = HandPath::orbit},
     {.stiffness = 500.0, .friction = 0.4},
     {.stiffness = 1000.0, .path = HandPath::taps}}};

Scene scene_of(const TradeTask& task) {
  Object object{.name = "object", .shape = Plane{}, .pose = {}, .material = {}};
  object.material.stiffness = task.stiffness;
  object.material.static_friction = task.friction;
  object.material.dynamic_friction = 0.75 * task.friction;
  if (task.ball) object.shape = Sphere{kTrafficBall};
  return Scene("trade", {object});
}

/// Returns the task of the hand. The hand has a stiffness of 300 N/m and an intended depth of
/// 10 mm, so it presses with up to 3 N.
HandTask hand_of(const TradeTask& task) {
  HandTask hand;
  hand.path = task.path;
  hand.clearance = kClearance;
  hand.lead_in = kBegin;
  if (task.path == HandPath::taps) hand.frequency = 2.0;
  if (task.ball) go_round(hand, kTrafficBall);
  return hand;
}

/// Returns the mean age [s] of the sample that the newest reply answers.
double mean_age(std::span<const NetworkSample> samples, double period) {
  double sum = 0.0;
  int count = 0;
  for (const NetworkSample& s : samples) {
    if (s.sample_index == 0) continue;
    sum += s.time - static_cast<double>(s.sample_index - 1) * period;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

double oscillation(const TradeTask& task, const std::vector<NetworkSample>& samples,
                   double period) {
  std::vector<double> heights;
  heights.reserve(samples.size());
  for (const NetworkSample& s : samples)
    heights.push_back(task.ball ? s.position.norm() - kTrafficBall : s.position.z());
  return highpass_rms(heights, 1.0 / period);
}

void add(const DatagramCount& count, double duration, double& kbit, double& datagrams) {
  kbit += count.kbit_per_second(duration) / kTrafficTasks.size();
  datagrams += static_cast<double>(count.datagrams) / duration / kTrafficTasks.size();
}

double computing(Nanoseconds time, double duration) {
  return std::chrono::duration<double>(time).count() / duration / kTrafficTasks.size();
}

TradeNetworkCell run_traffic_cell(const SessionParameters& parameters,
                                  const TwoWayLinkOptions& link, double duration) {
  TradeNetworkCell cell;
  for (const TradeTask& task : kTrafficTasks) {
    NetworkRunOptions options;
    options.hand.spec = builtin_device("simulated");
    options.hand.task = hand_of(task);
    options.parameters = parameters;
    options.link = link;
    options.duration = duration;
    options.timed = true;
    const NetworkRunResult run = run_network(scene_of(task), options);

    const double period = parameters.servo_period;
    const auto begin = std::min(run.samples.size(), static_cast<std::size_t>(kBegin / period));
    const auto counted = std::span(run.samples).subspan(begin);
    const Fidelity felt = fidelity(counted);
    cell.force_error += felt.relative_error() / kTrafficTasks.size();
    cell.direction_error += felt.direction.mean / kTrafficTasks.size();
    cell.added_delay += mean_age(counted, period) / kTrafficTasks.size();
    if (task.path != HandPath::taps)
      cell.oscillation += oscillation(task, run.samples, period) / 2.0;
    cell.passive = cell.passive && run.measured_port.violations() == 0;
    cell.server_time += computing(run.server_time, duration);
    cell.client_time += computing(run.client_time, duration);
    add(run.up, duration, cell.up_kbit, cell.up_datagrams);
    add(run.down, duration, cell.down_kbit, cell.down_datagrams);
  }
  cell.added_delay -= link.up.delay + link.down.delay;
  return cell;
}

class Settings {
 public:
  /// Adds a setting: `change` applied to the default session parameters. The hold time and the
  /// keep-alive time are longer than the default, to suit all packet rates.
  template <class Change>
  void add(const char* group, const std::string& name, const Change& change) {
    SessionParameters p;
    p.hold_time = 0.3;
    p.keep_alive = 0.1;
    change(p);
    p.batch = std::min({p.batch, p.packet_interval, kMaxRedundancy + 1 - p.redundancy});
    validate(p);
    settings.push_back({name, group, p});
  }
  std::vector<TrafficSetting> settings;
};

void set_rates(SessionParameters& p, double servo, double packets) {
  p.servo_period = 1.0 / servo;
  p.packet_interval = std::max(1, static_cast<int>(std::lround(servo / packets)));
}

std::string text(const char* format, auto... values) {
  std::string result;
  append(result, format, values...);
  return result;
}

void add_one_at_a_time(Settings& all) {
  for (const double rate : {1000.0, 500.0, 250.0, 100.0, 50.0, 25.0, 12.5})
    for (const bool model : {false, true})
      all.add("packet rate", text("%g Hz%s", rate, model ? ", model" : ""),
              [&](SessionParameters& p) {
                set_rates(p, 1000.0, rate);
                p.local_model = model;
              });
  for (const int batch : {1, 2, 4})
    all.add("batching, 250 Hz", text("%d a datagram", batch), [&](SessionParameters& p) {
      set_rates(p, 1000.0, 250.0);
      p.redundancy = 0;
      p.batch = batch;
    });
  for (const int k : {0, 1, 3, 8})
    all.add("redundancy", text("k = %d", k), [&](SessionParameters& p) { p.redundancy = k; });
  for (const double k : {0.0, 0.05, 0.1, 0.2})
    for (const Predictor predictor : {Predictor::level, Predictor::linear})
      all.add("force deadband", text("%.0f %% %s", 100.0 * k, name(predictor).data()),
              [&](SessionParameters& p) {
                p.force_deadband = k;
                p.predictor = predictor;
              });
  for (const double k : {0.05, 0.1, 0.2})
    for (const bool model : {false, true})
      all.add("position deadband", text("%.0f %%%s", 100.0 * k, model ? ", model" : ""),
              [&](SessionParameters& p) {
                p.position_deadband = k;
                p.local_model = model;
              });
  for (const double servo : {1000.0, 4000.0, 10000.0})
    for (const bool model : {false, true})
      for (const Storage storage : {Storage::minimal, Storage::elastic})
        all.add("servo rate and storage, 200 Hz",
                text("%.0f kHz, %s%s", 1e-3 * servo, name(storage).data(), model ? ", model" : ""),
                [&](SessionParameters& p) {
                  set_rates(p, servo, 200.0);
                  p.local_model = model;
                  p.storage = storage;
                });
}

void add_crossed(Settings& all) {
  for (const double rate : {1000.0, 250.0, 100.0, 50.0, 25.0, 12.5})
    for (const bool model : {false, true})
      for (const double deadband : {0.0, 0.1})
        for (const int k : {0, 3})
          all.add("all",
                  text("%g Hz, k = %d%s%s", rate, k, deadband > 0.0 ? ", force 10 %" : "",
                       model ? ", model" : ""),
                  [&](SessionParameters& p) {
                    set_rates(p, 1000.0, rate);
                    p.redundancy = k;
                    p.force_deadband = deadband;
                    p.local_model = model;
                  });
}

}  // namespace

std::vector<TrafficSetting> traffic_settings() {
  Settings all;
  add_one_at_a_time(all);
  add_crossed(all);
  for (const NetworkProfile& profile : kNetworkProfiles)
    all.add("profile", std::string(profile.name),
            [&](SessionParameters& p) { p = over(profile, {}); });
  return all.settings;
}

std::vector<TradeNetworkCell> run_trade_network(const std::vector<TrafficSetting>& settings,
                                                double duration) {
  std::vector<TwoWayLinkOptions> links;
  for (const TradeLink& link : kTradeLinks) links.push_back(parse_link(link.items));
  std::vector<TradeNetworkCell> cells(settings.size() * links.size());
  parallel_for(cells.size(), [&](std::size_t i) {
    const std::size_t setting = i / links.size(), link = i % links.size();
    cells[i] = run_traffic_cell(settings[setting].parameters, links[link], duration);
    cells[i].setting = setting;
    cells[i].link = link;
  });
  return cells;
}

std::vector<std::size_t> pareto_front(const std::vector<TradeNetworkCell>& cells,
                                      std::size_t link) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i].link == link) order.push_back(i);
  const auto bandwidth = [&](std::size_t i) { return cells[i].up_kbit + cells[i].down_kbit; };
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return bandwidth(a) != bandwidth(b) ? bandwidth(a) < bandwidth(b)
                                        : cells[a].force_error < cells[b].force_error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || cells[i].force_error < cells[front.back()].force_error) front.push_back(i);
  return front;
}

}  // namespace feltwire
