#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/compare.hpp"
#include "sim/studies/bound/compare_plot.hpp"

namespace feltwire {
namespace {

std::string csv(const std::vector<CompareRow>& rows) {
  std::string text = "task,method,oscillation_um,direction_error_deg,displayed,energy_made_mj\n";
  for (const CompareRow& r : rows)
    append(text, "%s,%s,%.6g,%.6g,%.6g,%.6g\n", r.task.c_str(), r.method.c_str(),
           r.oscillation * 1e6, r.direction_error * kDegrees, r.displayed, r.energy_made * 1e3);
  return text;
}

std::string cost_csv(const std::vector<CompareRow>& rows) {
  std::string text = "task,method,cost_ns\n";
  for (const CompareRow& r : rows)
    append(text, "%s,%s,%.1f\n", r.task.c_str(), r.method.c_str(), r.cost);
  return text;
}

std::string hands_csv(const std::vector<CompareHandsRow>& rows) {
  std::string text =
      "task,method,oscillation_median_um,oscillation_worst_um,displayed_median,displayed_worst,"
      "energy_made_worst_mj\n";
  for (const CompareHandsRow& r : rows)
    append(text, "%s,%s,%.6g,%.6g,%.6g,%.6g,%.6g\n", r.task.c_str(), r.method.c_str(),
           r.oscillation * 1e6, r.worst_oscillation * 1e6, r.displayed, r.least_displayed,
           r.energy_made * 1e3);
  return text;
}

nlohmann::ordered_json json(const std::vector<CompareRow>& rows, const CompareLoop& loop) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const CompareRow& r : rows)
    list.push_back({{"task", r.task},
                    {"method", r.method},
                    {"oscillation_um", r.oscillation * 1e6},
                    {"direction_error_deg", r.direction_error * kDegrees},
                    {"displayed", r.displayed},
                    {"energy_made_mj", r.energy_made * 1e3}});
  return {{"damping", loop.damping},
          {"rate_hz", loop.rate},
          {"delay_ms", loop.delay * 1e3},
          {"delay_samples", delay_samples(loop.delay, 1.0 / loop.rate)},
          {"rows", list}};
}

}  // namespace

std::vector<CompareRow> write_compare(const std::filesystem::path& directory,
                                      const CompareLoop& loop,
                                      const std::vector<CompareTask>& tasks,
                                      const std::vector<Method>& methods) {
  std::vector<CompareRow> rows = compare(tasks, methods, loop);
  std::filesystem::create_directories(directory);
  write_text(directory / "compare.csv", csv(rows));
  write_text(directory / "compare_cost.csv", cost_csv(rows));
  write_text(directory / "compare.json", json(rows, loop).dump(1) + '\n');
  return rows;
}

Comparison write_compare(const std::filesystem::path& directory, const CompareLoop& loop) {
  const std::vector<CompareTask> tasks = compare_tasks();
  const std::vector<Method> all{methods().begin(), methods().end()};
  Comparison result{write_compare(directory, loop, tasks, all), compare_hands(tasks, all, loop)};
  write_text(directory / "compare_hands.csv", hands_csv(result.hands));
  draw_compare(directory, result.rows, loop);
  return result;
}

std::string compare_table(const std::vector<CompareRow>& rows) {
  std::string text =
      "                                           oscillation  direction   displayed  energy     "
      "cost\n"
      "task        method                         [um]         error[deg]             made [mJ]  "
      "[ns]\n";
  std::string last;
  for (const CompareRow& r : rows) {
    if (!last.empty() && r.task != last) text += '\n';
    append(text, "%-11s %-29s %12.1f  %10.1f  %9.2f  %9.2f  %5.0f\n",
           r.task == last ? "" : r.task.c_str(), r.method.c_str(), r.oscillation * 1e6,
           r.direction_error * kDegrees, r.displayed, r.energy_made * 1e3, r.cost);
    last = r.task;
  }
  return text;
}

std::string compare_hands_table(const std::vector<CompareHandsRow>& rows) {
  std::string text =
      "\nThe same by eight hands: the median of the hands, and the worst\n"
      "                                           oscillation [um]   displayed      energy\n"
      "task        method                          median    worst  median  worst  made [mJ]\n";
  std::string last;
  for (const CompareHandsRow& r : rows) {
    if (!last.empty() && r.task != last) text += '\n';
    append(text, "%-11s %-29s %8.1f %8.1f  %6.2f %6.2f  %9.2f\n",
           r.task == last ? "" : r.task.c_str(), r.method.c_str(), r.oscillation * 1e6,
           r.worst_oscillation * 1e6, r.displayed, r.least_displayed, r.energy_made * 1e3);
    last = r.task;
  }
  return text;
}

}  // namespace feltwire
