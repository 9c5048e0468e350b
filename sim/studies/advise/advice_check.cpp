#include "sim/studies/advise/advice_check.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/parallel.hpp"

namespace feltwire::advise {
namespace {

constexpr int kMostCases = 10'000;

Compared compare(const Predicted& predicted, double measured) {
  return {predicted.value, measured, predicted.low <= measured && measured <= predicted.high};
}

const Felt& felt_on(const Advice& advice, const Place& place) {
  const auto found = std::ranges::find(advice.feel, place.material.stiffness, &Felt::wall);
  return found != advice.feel.end() ? *found : advice.feel.front();
}

double score_of(const Measured& measured, const Place& place) {
  return measured.calm() ? std::min(1.0, measured.felt / place.material.stiffness) : 0.0;
}

/// Returns the mean score of a setting in a case; also a setting that a session refuses has one, 0.
double score_of(const DrawnCase& drawn, const Setting& setting) {
  if (!is_possible(drawn.device, setting)) return 0.0;
  double sum = 0.0;
  for (const Place& place : drawn.places)
    sum += score_of(measured_press(drawn, setting, place, false), place);
  return sum / static_cast<double>(drawn.places.size());
}

/// Measures a press. The computing times are the least of some runs, because other programs
/// interrupt them.
Measured timed_press(const DrawnCase& drawn, const Setting& setting, const Place& place) {
  constexpr int kRuns = 3;
  Measured measured = measured_press(drawn, setting, place, true);
  for (int n = 1; n < kRuns; ++n) {
    const Measured again = measured_press(drawn, setting, place, true);
    measured.server = std::min(measured.server, again.server);
    measured.client = std::min(measured.client, again.client);
  }
  return measured;
}

CheckedCase check_case(const DrawnCase& drawn, const std::optional<MachineSpeed>& machine) {
  const Question question{
      .device = drawn.device, .link = parse_link(drawn.link), .explains = false};
  const Advice advice = advise(question, drawn.scene, drawn.places, machine);
  CheckedCase row{.seed = drawn.seed, .setting = advice.setting};
  Measured most;
  for (const Place& place : drawn.places) {
    const Measured measured = timed_press(drawn, advice.setting, place);
    const Felt& felt = felt_on(advice, place);
    row.felt.push_back(compare({felt.felt, felt.low, felt.high}, measured.felt));
    row.calm.push_back({felt.swing, measured.oscillation, felt.calm() == measured.calm()});
    row.passive = row.passive && measured.passive;
    row.score += score_of(measured, place) / static_cast<double>(drawn.places.size());
    most.news_age = std::max(most.news_age, measured.news_age);
    most.up_kbit = std::max(most.up_kbit, measured.up_kbit);
    most.down_kbit = std::max(most.down_kbit, measured.down_kbit);
    most.server = std::max(most.server, measured.server);
    most.client = std::max(most.client, measured.client);
  }
  row.news_age = compare(advice.news_age, most.news_age);
  row.up = compare(advice.up, most.up_kbit);
  row.down = compare(advice.down, most.down_kbit);
  row.server = compare(advice.server, most.server);
  row.client = compare(advice.client, most.client);
  return row;
}

void search(const DrawnCase& drawn, const std::vector<Setting>& settings, CheckedCase& row) {
  std::vector<double> scores(settings.size());
  parallel_for(settings.size(), [&](std::size_t i) { scores[i] = score_of(drawn, settings[i]); });
  const auto best = std::ranges::max_element(scores);
  row.best = std::max(*best, row.score);
  row.best_setting =
      *best > row.score ? settings[static_cast<std::size_t>(best - scores.begin())] : row.setting;
}

}  // namespace

double Compared::error() const {
  if (predicted == measured) return 0.0;
  return std::abs(predicted - measured) / std::max(std::abs(measured), 1e-12);
}

std::vector<Setting> all_settings() {
  constexpr double kMostRate = 4000.0;  // [Hz]
  std::vector<Setting> all;
  for (const Setting& law : law_choices(kMostRate)) {
    for (const Setting& choice : traffic_choices(law, false)) all.push_back(choice);
    Setting alone = law;
    alone.profile = "lan";
    alone.local_model = false;
    all.push_back(alone);
  }
  return all;
}

std::vector<CheckedCase> check_advice(const CheckOptions& options) {
  if (options.cases < 2 || options.cases > kMostCases)
    throw std::invalid_argument("--cases must be 2 to 10000");
  if (options.searched < 0 || options.searched > options.cases / 2)
    throw std::invalid_argument("--searched must be 0 to half of --cases");
  const std::vector<DrawnCase> drawn = drawn_cases(options.seed, options.cases);
  std::vector<CheckedCase> rows(drawn.size());
  parallel_for(rows.size(), [&](std::size_t i) { rows[i] = check_case(drawn[i], {}); });
  const std::size_t half = drawn.size() / 2;
  const std::vector<Setting> settings = all_settings();
  for (std::size_t i = half; i < rows.size(); ++i) {
    rows[i].judged = true;
    if (i < half + static_cast<std::size_t>(options.searched)) search(drawn[i], settings, rows[i]);
  }
  return rows;
}

}  // namespace feltwire::advise
