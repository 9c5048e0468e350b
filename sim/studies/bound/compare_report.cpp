#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "sim/measure/metrics.hpp"
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
                                      const CompareLoop& loop) {
  auto rows = compare(compare_tasks(), {methods().begin(), methods().end()}, loop);
  std::filesystem::create_directories(directory);
  write_text(directory / "compare.csv", csv(rows));
  write_text(directory / "compare_cost.csv", cost_csv(rows));
  write_text(directory / "compare.json", json(rows, loop).dump(1) + '\n');
  draw_compare(directory, rows, loop);
  return rows;
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

}  // namespace feltwire
