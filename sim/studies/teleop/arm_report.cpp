#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/studies/teleop/arm_bench.hpp"

namespace feltwire::teleop::with_arm {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

void write_arm(const std::filesystem::path& directory, const std::vector<ArmRow>& rows) {
  std::filesystem::create_directories(directory);
  Json list = Json::array();
  for (const ArmRow& row : rows) {
    const ArmMeasured& m = row.measured;
    list.push_back({{"task", row.made.task},
                    {"rtt_ms", row.made.round_trip * kMilli},
                    {"jitter_ms", row.made.jitter * kMilli},
                    {"loss", row.made.loss},
                    {"seed", row.made.seed},
                    {"intended_n", m.intended},
                    {"peak_force_n", m.peak},
                    {"peak_over_intended", m.peak / m.intended},
                    {"set_down_peak_n", m.set_down ? Json(*m.set_down) : Json(nullptr)},
                    {"robot_force_n", m.robot_force},
                    {"hand_force_n", m.hand_force},
                    {"force_error_n", m.force_error},
                    {"swing_um", m.swing * kMicro},
                    {"flicker_n", m.flicker},
                    {"displayed_over_series", m.displayed ? Json(*m.displayed) : Json(nullptr)},
                    {"offset_mm", m.offset * kMilli},
                    {"energy_made_j", m.energy_made},
                    {"lifted_mm", m.lifted ? Json(*m.lifted * kMilli) : Json(nullptr)},
                    {"stopped", m.stopped}});
  }
  write_text(directory / "arm.json", list.dump(0) + '\n');
}

std::string arm_table(const std::vector<ArmRow>& rows) {
  std::string text =
      "\nfeltwire's law with the simulated arm: median over the seeds, and the worst (of flicker "
      "and displayed: the worst)\n"
      "  task    rtt ms jitter   loss seeds|intended N   peak N peak / intended   robot N "
      "hand / robot        swing um offset mm flicker N displayed lifted mm   made J\n";
  for (auto first = rows.begin(); first != rows.end();) {
    const ArmCase& c = first->made;
    const auto last = std::find_if(first, rows.end(), [&](const ArmRow& r) {
      return r.made.task != c.task || r.made.round_trip != c.round_trip ||
             r.made.jitter != c.jitter || r.made.loss != c.loss;
    });
    const auto over = [&](auto figure) {
      std::vector<double> values;
      for (auto row = first; row != last; ++row) values.push_back(figure(row->measured));
      std::ranges::sort(values);
      return values;
    };
    const auto middle = [&](auto figure) {
      const std::vector<double> values = over(figure);
      return values[(values.size() - 1) / 2];
    };
    const auto ratio = [](const ArmMeasured& m) { return m.peak / m.intended; };
    const auto share = [](const ArmMeasured& m) { return m.hand_force / m.robot_force; };
    const auto off = [&](const ArmMeasured& m) { return std::abs(share(m) - 1.0); };
    append(text, "  %-6s %7.0f %6.0f %6.2f %5d|%10.2f %8.2f %6.2f, %6.2f %9.2f %6.2f, off %5.2f",
           c.task.c_str(), c.round_trip * kMilli, c.jitter * kMilli, c.loss,
           static_cast<int>(last - first), middle([](const ArmMeasured& m) { return m.intended; }),
           middle([](const ArmMeasured& m) { return m.peak; }), middle(ratio), over(ratio).back(),
           middle([](const ArmMeasured& m) { return m.robot_force; }), middle(share),
           over(off).back());
    append(text, " %8.1f %9.1f %9.2f",
           middle([](const ArmMeasured& m) { return m.swing; }) * kMicro,
           middle([](const ArmMeasured& m) { return m.offset; }) * kMilli,
           over([](const ArmMeasured& m) { return m.flicker; }).back());
    if (first->measured.displayed)
      append(text, " %9.2f",
             over([](const ArmMeasured& m) { return m.displayed.value_or(0.0); }).front());
    else
      text += "         -";
    if (first->measured.lifted)
      append(text, " %9.1f",
             middle([](const ArmMeasured& m) { return m.lifted.value_or(0.0); }) * kMilli);
    else
      text += "         -";
    const bool stopped =
        std::any_of(first, last, [](const ArmRow& r) { return r.measured.stopped; });
    append(text, " %8.2g%s\n", over([](const ArmMeasured& m) { return m.energy_made; }).back(),
           stopped ? "  STOPPED" : "");
    first = last;
  }
  return text;
}

}  // namespace feltwire::teleop::with_arm
