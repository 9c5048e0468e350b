#include "sim/studies/advise/advice.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/studies/advise/scene_advice.hpp"

namespace feltwire::advise {
namespace {

constexpr int kMostHands = 1'000'000, kMostCores = 4096;
constexpr double kAlike = 0.02;           // of the felt share; the preferred setting of those wins
constexpr double kLineShare = 0.8;        // of a line's rate that datagrams may fill
constexpr double kEnoughLeft = 0.99;      // share of a command that a good link leaves
constexpr double kHandSpeed = 0.5;        // [m/s] of a hand that moves between objects
constexpr std::size_t kBodyReply = 1000;  // [bytes] of a reply about a tool with a body
constexpr double kWholeReach = 0.75;      // of a local model's reach, in which it alone counts
// Bands: docs/lab/advise.md, "Bands".
constexpr double kAgeBand = 0.10, kTrafficBand = 0.10, kCostBand = 0.5, kMemoryBand = 0.3;
constexpr double kSwingBand = 10e-6;  // [m]

Predicted within(double value, double band) {
  return {value, (1.0 - band) * value, (1.0 + band) * value};
}

/// The walls on which the laws are compared: all stiffnesses, or the stiffest, the middle and the
/// softest of many.
std::vector<double> compared_walls(const SceneFacts& facts) {
  constexpr std::size_t kMost = 3;
  std::vector<double> walls;
  for (const Place& material : facts.materials) walls.push_back(material.material.stiffness);
  if (walls.empty()) walls.push_back(facts.stiffest);
  if (walls.size() <= kMost) return walls;
  return {walls.front(), walls[walls.size() / 2], walls.back()};
}

/// The mean share of the walls that is felt; a hand that swings counts as 0.
double mean_share(const DeviceSpec& device, const Setting& setting,
                  const std::vector<double>& walls) {
  double sum = 0.0;
  for (const double wall : walls) {
    sum += std::min(1.0, felt_of(device, setting, wall, 1.0).calm_share);
  }
  return sum / static_cast<double>(walls.size());
}

Setting best_law(const Question& question, const std::vector<double>& walls) {
  std::vector<std::pair<Setting, double>> tried;
  double best = 0.0;
  for (const Setting& setting : law_choices(question.most_rate)) {
    // Below 2b/T the storage decides how a soft wall gives its force back, not its stiffness.
    const double limit = damping_limit(question.device, 1.0 / setting.rate);
    const bool soft = *std::ranges::min_element(walls) < limit;
    if (!is_possible(question.device, setting)) continue;
    if (setting.law == "contact_frame" && (setting.storage == Storage::elastic) != soft) continue;
    const double share = mean_share(question.device, setting, walls);
    tried.emplace_back(setting, share);
    best = std::max(best, share);
    if (share > 1.0 - kAlike) break;  // no later one is better by more
  }
  for (const auto& [setting, share] : tried)
    if (share >= best - kAlike) return setting;
  throw std::invalid_argument(
      "no law is possible with device '" + question.device.name +
      "' at these servo rates, because its motor lags too long; give a lower --most-rate, or "
      "measure its actuation_lag with feltwire-client identify");
}

/// A choice of traffic, and its effects.
struct TrafficOffer {
  Setting setting;
  Traffic traffic{};
  NewsAge age{};
  double fade = 0.0;
  bool fits = false;     // the line
  bool reaches = false;  // the local model until the next one
};

bool fits(const LinkOptions& line, const Flow& flow) {
  return !(line.rate > 0.0) || 8.0 * flow.bytes / flow.interval <= kLineShare * line.rate;
}

TrafficOffer offer_of(const Question& question, const Setting& setting, const PlaceCost& place,
                      bool moving) {
  TrafficOffer offer{.setting = setting};
  const SessionParameters p = setting.parameters();
  offer.traffic = traffic_of(p, question.device, question.link, place.reply_bytes, moving);
  offer.age = news_age(question.link, offer.traffic.up, offer.traffic.down, p.servo_period);
  const bool each = offer.traffic.answered > kWholeReach;
  const Losses up = losses(question.link.up), down = losses(question.link.down);
  const double interval = p.packet_interval * p.servo_period;
  offer.fade = each ? mean_fade(both_ways(up, down), interval, p.hold_time)
                    : mean_fade(down, offer.traffic.down.interval, p.hold_time);
  offer.fits =
      fits(question.link.up, offer.traffic.up) && fits(question.link.down, offer.traffic.down);
  offer.reaches = kHandSpeed * offer.age.total <= kWholeReach * place.reach;
  return offer;
}

TrafficOffer best_traffic(const Question& question, const Setting& law, const PlaceCost& place,
                          bool moving) {
  std::vector<TrafficOffer> offers;
  for (const Setting& setting : traffic_choices(law, moving))
    offers.push_back(offer_of(question, setting, place, moving));
  for (const TrafficOffer& offer : offers)
    if (offer.fits && offer.fade >= kEnoughLeft) return offer;
  // None is good: the one that leaves the most, of those that fit.
  const auto worth = [](const TrafficOffer& offer) { return offer.fits ? 1.0 + offer.fade : 0.0; };
  return *std::ranges::max_element(offers, {}, worth);
}

/// The dearest place.
PlaceCost dearest(const Scene& scene, const std::vector<Place>& places, bool rotation) {
  PlaceCost all;
  all.reach = -1.0;
  for (const Place& place : places) {
    const PlaceCost one = cost_at(scene, place, true, rotation);
    all.patches = std::max(all.patches, one.patches);
    all.reply_bytes = std::max(all.reply_bytes, one.reply_bytes);
    all.touch = std::max(all.touch, one.touch);
    all.model = std::max(all.model, one.model);
    all.reach = all.reach < 0.0 ? one.reach : std::min(all.reach, one.reach);
  }
  return all;
}

void add_reasons(const Question& question, const TrafficOffer& offer, bool moving, Advice& advice) {
  const auto line = [&](const char* format, auto... values) {
    std::string text;
    append(text, format, values...);
    advice.reasons.push_back(text);
  };
  const Setting& s = offer.setting;
  line("law %s: it shows the most of these materials on this device%s", s.mode_option().c_str(),
       std::ranges::all_of(advice.feel, &Felt::calm)
           ? ", and is calm"
           : "; a hand swings on some of them, so use softer ones or a better part");
  line("side client: the bound at the device alone makes the port passive over this link");
  line("local model whole: a force over this link would be %.1f ms old",
       kMilli * (offer.age.total));
  if (s.profile == "wan")
    line("traffic %s: %s", s.traffic_option().c_str(),
         s.force_deadband ? "the model leaves nothing for more datagrams to improve"
                          : "every datagram is answered, because answers are lost");
  if (s.profile == "lan")
    line("traffic lan: %s", moving ? "bodies move, and each datagram brings news of them"
                                   : "fewer datagrams would let the force fade between them");
  if (s.profile == "thin") line("traffic thin: the line has no room for more");
  if (s.rate != 1000.0)
    line("servo rate %.0f Hz: it shows more than 1000 Hz (up to %.0f Hz were compared)", s.rate,
         question.most_rate);
}

/// Finds what limits the session beside the materials, and the remedy.
void add_limit(const Question& question, const TrafficOffer& offer, const PlaceCost& place,
               Advice& advice) {
  const auto remedy = [&](Limit limit, const char* format, auto... values) {
    if (advice.limit == Limit::nothing) advice.limit = limit;
    std::string text;
    append(text, format, values...);
    advice.remedies.push_back(text);
  };
  if (!offer.fits)
    remedy(Limit::line, "the line is too thin: it needs %.0f kbit/s up and %.0f down",
           offer.traffic.up.kbit_per_second() / kLineShare,
           offer.traffic.down.kbit_per_second() / kLineShare);
  if (offer.fade < kEnoughLeft)
    remedy(Limit::loss, "loss lets commands fade: the mean force is %.2f of what it would be",
           offer.fade);
  if (place.reach > 0.0 && !offer.reaches)
    remedy(Limit::delay,
           "delay: a hand at %.1f m/s leaves the local model before the next one comes; it may "
           "move at %.2f m/s",
           kHandSpeed, kWholeReach * place.reach / offer.age.total);
  if (advice.cores_needed > question.cores)
    remedy(Limit::cpu, "CPU: %d hands need %d cores of the server, and there are %d",
           question.hands, advice.cores_needed, question.cores);
  if (question.device.continuous_force < 3.0)
    remedy(Limit::motor, "motor: it holds %.2g N for long; a hand that presses harder goes through",
           question.device.continuous_force);
}

}  // namespace

void validate(const Question& question) {
  validate(question.device);
  validate(question.link.up);
  validate(question.link.down);
  if (!(question.device.continuous_force > 0.0) && !(question.device.max_force > 0.0))
    throw std::invalid_argument("device '" + question.device.name +
                                "' gives no force; give one with max_force above 0 N");
  if (question.hands < 1 || question.hands > kMostHands)
    throw std::invalid_argument("--hands must be 1 to 1000000");
  if (question.cores < 1 || question.cores > kMostCores)
    throw std::invalid_argument("--cores must be 1 to 4096");
  if (!(question.most_rate >= 10.0) || !(question.most_rate <= 1e5))
    throw std::invalid_argument("--most-rate must be 10 to 100000 Hz");
}

std::vector<Place> start_places(const Scene& scene) {
  return {{.point = scene.start().position, .normal = scene.start().normal}};
}

Advice advise(const Question& question, const Scene& scene, const std::vector<Place>& places,
              const std::optional<MachineSpeed>& machine) {
  validate(question);
  const SceneFacts facts = facts_of(scene);
  const bool moving = facts.moving > 0;
  const Setting law = best_law(question, compared_walls(facts));
  const bool body = scene.tool().body != nullptr;
  const PlaceCost place = body ? PlaceCost{.reply_bytes = kBodyReply}
                               : dearest(scene, places, question.device.rotation_actuated > 0);
  const TrafficOffer offer = best_traffic(question, law, place, moving);
  Advice advice{.setting = offer.setting};
  advice.fade = offer.fade;
  for (const Place& material : facts.materials)
    advice.feel.push_back(
        question.explains
            ? explained(question.device, offer.setting, material.material.stiffness, offer.fade,
                        question.most_rate)
            : felt_of(question.device, offer.setting, material.material.stiffness, offer.fade));
  double swing = 0.0;
  for (const Felt& felt : advice.feel) swing = std::max(swing, felt.swing);
  advice.oscillation = {swing, 0.0, std::max(2.0 * swing, kSwingBand)};
  const double half_tick = 0.5 / offer.setting.rate;
  advice.force_delay = within(half_tick + question.device.actuation.lag +
                                  question.device.actuation.late_ticks / offer.setting.rate,
                              kAgeBand);
  advice.news_age = within(offer.age.total, kAgeBand);
  advice.link_delay = offer.age.link;
  advice.up = within(offer.traffic.up.kbit_per_second(), kTrafficBand);
  advice.down = within(offer.traffic.down.kbit_per_second(), kTrafficBand);
  const MachineSpeed speed = machine ? *machine : measure_machine(question.device, offer.setting);
  advice.cost = cost_of(speed, facts, place, offer.setting, offer.traffic,
                        1.0 - losses(question.link.up).share, question.hands);
  advice.server = within(advice.cost.server, kCostBand);
  advice.client = within(advice.cost.client, kCostBand);
  advice.hands_a_core = within(advice.cost.hands_a_core, kCostBand);
  advice.server_memory = within(advice.cost.server_memory, kMemoryBand);
  advice.session_memory = within(advice.cost.session_memory, kMemoryBand);
  advice.client_memory = within(advice.cost.client_memory, kMemoryBand);
  const double cores = question.hands / std::max(1e-9, advice.cost.hands_a_core);
  advice.cores_needed = static_cast<int>(std::ceil(std::min(cores, 1e6)));
  add_reasons(question, offer, moving, advice);
  add_limit(question, offer, place, advice);
  advice.scene = scene_advice(facts);
  return advice;
}

}  // namespace feltwire::advise
