#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/studies/scene/trade_sixdof.hpp"

namespace feltwire {
namespace {

constexpr double kToMicro = 1e-3, kToKilo = 1e-3;

}  // namespace

std::string trade_sixdof_table(const std::vector<SixDofCell>& cells) {
  std::string text =
      "                                 error [%]      reference's      largest    jump [N]        "
      "step [us]     memory  stable to\n"
      "task      contact   mass       force  torque   force  torque   force [N]    own  finer     "
      "p50    p99.9    [kB]     [kN/m]\n";
  for (const SixDofCell& c : cells) {
    if (&c != &cells.front() && c.task != (&c - 1)->task) text += '\n';
    append(text, "%-9s %-8s  %-8s %7.2f %7.2f %7.2f %7.2f   %9.3f %6.3f %6.3f %7.1f %8.1f %7.1f  ",
           c.task.c_str(), c.contact.c_str(), c.mass.c_str(), kPercent * c.force_error,
           kPercent * c.torque_error, kPercent * c.reference_force_error,
           kPercent * c.reference_torque_error, c.largest_force, c.jump, c.reference_jump,
           kToMicro * c.median_ns, kToMicro * c.p99_9_ns, kToKilo * static_cast<double>(c.bytes));
    if (c.stable.stiffness > 0.0)
      append(text, "%s%9.3g\n", c.stable.above_range ? ">" : " ", kToKilo * c.stable.stiffness);
    else
      text += "         -\n";
  }
  return text;
}

void write_trade_sixdof(const std::filesystem::path& directory,
                        const std::vector<SixDofCell>& cells) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "task,contact,mass,force_error_percent,torque_error_percent,reference_force_error_percent,"
      "reference_torque_error_percent,largest_force_n,jump_n,reference_jump_n,bytes,"
      "stable_stiffness,stable_above_range\n";
  std::string cost = "task,contact,mass,p50_ns,p99_9_ns\n";
  auto document = nlohmann::ordered_json::array();
  for (const SixDofCell& c : cells) {
    append(csv, "%s,%s,%s,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%zu,%.6g,%d\n", c.task.c_str(),
           c.contact.c_str(), c.mass.c_str(), kPercent * c.force_error, kPercent * c.torque_error,
           kPercent * c.reference_force_error, kPercent * c.reference_torque_error, c.largest_force,
           c.jump, c.reference_jump, c.bytes, c.stable.stiffness, c.stable.above_range ? 1 : 0);
    append(cost, "%s,%s,%s,%.4g,%.4g\n", c.task.c_str(), c.contact.c_str(), c.mass.c_str(),
           c.median_ns, c.p99_9_ns);
    document.push_back({{"task", c.task},
                        {"contact", c.contact},
                        {"mass", c.mass},
                        {"force_error_percent", kPercent * c.force_error},
                        {"torque_error_percent", kPercent * c.torque_error},
                        {"reference_force_error_percent", kPercent * c.reference_force_error},
                        {"reference_torque_error_percent", kPercent * c.reference_torque_error},
                        {"largest_force_n", c.largest_force},
                        {"jump_n", c.jump},
                        {"reference_jump_n", c.reference_jump},
                        {"bytes", c.bytes},
                        {"stable_stiffness", c.stable.stiffness},
                        {"stable_above_range", c.stable.above_range}});
  }
  write_text(directory / "trade_sixdof.csv", csv);
  write_text(directory / "trade_sixdof.json", document.dump(1) + '\n');
  write_text(directory / "trade_sixdof_cost.csv", cost);
}

}  // namespace feltwire
