#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/step_cost.hpp"
#include "sim/published_laws/published_laws.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/bound/frontier.hpp"
#include "sim/studies/bound/over_hands.hpp"

namespace feltwire {
namespace {

using Json = nlohmann::ordered_json;

Json json(const FrontierRow& row, double cost) {
  const FrontierCase& c = row.made;
  return {{"task", c.task},
          {"law", c.law},
          {"need", kNeedNames[static_cast<std::size_t>(c.need)]},
          {"b", c.damping},
          {"device", c.device.name},
          {"mass", c.device.mass},
          {"wall", c.wall},
          {"delay_ms", c.delay * kMilli},
          {"hand", c.hand.name},
          {"cold", c.cold},
          {"local_model", c.session},
          {"oscillation_um", row.oscillation * kMicro},
          {"displayed_share", row.displayed},
          {"direction_error_deg", row.direction_error * kDegrees},
          {"energy_made_j", row.energy_made},
          {"made_at_motor_j", row.energy.made},
          {"given_to_hand_j", row.energy.to_hand},
          {"excess_count", row.excess},
          {"cost_ns", cost}};
}

std::string csv(const std::vector<FrontierRow>& rows) {
  std::string text =
      "task,law,need,b,device,wall,delay_ms,hand,cold,local_model,oscillation_um,displayed_share,"
      "direction_error_deg,energy_made_j,made_at_motor_j,given_to_hand_j,excess_count\n";
  for (const FrontierRow& r : rows) {
    const FrontierCase& c = r.made;
    append(text, "%s,%s,%s,%g,%s,%g,%g,%s,%d,%d,%.4g,%.5g,%.4g,%.4g,%.4g,%.4g,%llu\n",
           c.task.c_str(), c.law.c_str(),
           std::string(kNeedNames[static_cast<std::size_t>(c.need)]).c_str(), c.damping,
           std::string(c.device.name).c_str(), c.wall, c.delay * kMilli,
           std::string(c.hand.name).c_str(), c.cold ? 1 : 0, c.session ? 1 : 0,
           r.oscillation * kMicro, r.displayed, r.direction_error * kDegrees, r.energy_made,
           r.energy.made, r.energy.to_hand, static_cast<unsigned long long>(r.excess));
  }
  return text;
}

/// Returns the computing time [ns] of one step of the force law and the energy account, for a hand
/// that oscillates in a wall.
double swing_cost(const std::string& name, Need need) {
  ExperimentSetup setup;
  setup.law = &law(name);
  setup.bounding.damping = 0.5;
  if (need != Need::no_account) {
    PortKnowledge& known = setup.account.emplace().translation;
    known.damping = setup.bounding.damping;
    known.mass = need == Need::unknown_hand ? 0.0 : kFrontierDevices[0].mass;
    known.outside_force = kHandForce;
  }
  constexpr int kCostSteps = 20000;
  std::vector<ExperimentSample> samples(kCostSteps);
  for (int n = 0; n < kCostSteps; ++n) {
    samples[n].displacement = {0.0, 1e-5 * ((n & 7) - 3.5), 2e-6};
    samples[n].commanded.elastic = {0.0, 2.0 + (n & 7), 0.1};
  }
  return step_cost(samples, setup);
}

using Costs = std::map<std::pair<std::string, Need>, double>;

Costs step_costs(const std::vector<FrontierRow>& rows) {
  Costs costs;
  for (const FrontierRow& row : rows) {
    const std::pair key{row.made.law, row.made.need};
    if (!costs.contains(key)) costs[key] = swing_cost(key.first, key.second);
  }
  return costs;
}

struct Curve {
  const char *law, *title;
  Need need;
};
constexpr std::array kCurves = {Curve{"none", "none", Need::no_account},
                                Curve{"contact_frame", "contact_frame", Need::no_account},
                                Curve{"credited", "credited + account", Need::inertia_friction},
                                Curve{"midpoint", "midpoint + account", Need::inertia_friction}};

bool of_curve(const FrontierCase& c, const Curve& curve) {
  return c.law == curve.law && c.need == curve.need;
}

// Okabe and Ito chose these colours for colour-blind readers.
constexpr std::array kColors = {"#999999", "#0072b2", "#e69f00", "#009e73"};

/// Draws the displayed stiffness [N/m] over x in two panels: the median of the hands, and the worst
/// hand.
void draw(const std::filesystem::path& directory, const std::vector<FrontierRow>& rows,
          const std::string& name, const std::string& title, const std::string& x_label,
          const std::vector<double>& xs,
          const std::function<bool(const FrontierCase&, double x)>& at, double wall) {
  std::string data = "x";
  for (const Curve& curve : kCurves)
    for (const char* kind : {"median", "worst"}) append(data, ",%s_%s", curve.law, kind);
  data += '\n';
  for (const double x : xs) {
    append(data, "%g", x);
    for (const Curve& curve : kCurves) {
      const OverHands o = over_hands(rows, [&](const FrontierCase& c) {
        return at(c, x) && of_curve(c, curve) && c.wall == wall;
      });
      append(data, o.hands ? ",%.5g,%.5g" : ",nan,nan", std::max(1.0, o.median * wall),
             std::max(1.0, o.worst * wall));
    }
    data += '\n';
  }
  write_text(directory / (name + ".csv"), data);
  const auto panel = [&](const char* which, std::size_t column) {
    std::string text = std::string("set title '") + which + "'\nplot ";
    for (std::size_t i = 0; i < kCurves.size(); ++i)
      append(text,
             "%s'%s.csv' skip 1 using 1:%zu with linespoints lw 2 pt 7 lc rgb '%s' title '%s'",
             i ? ", " : "", name.c_str(), column + 2 * i, kColors[i], kCurves[i].title);
    return text + '\n';
  };
  std::string styles =
      "set datafile separator ','\nset grid lt 1 lc rgb '#dddddd'\nset logscale y\n"
      "set ylabel 'displayed stiffness [N/m]; 1: it swings'\nset key top left maxrows 2 samplen 2\n"
      "set yrange [0.8:5e5]\nset title noenhanced\nset key noenhanced\n";
  append(styles, "set xlabel '%s'\n", x_label.c_str());
  if (x_label.find("damping") != std::string::npos) styles += "set logscale x\n";
  plot_pair(directory, name, 520, styles, title, panel("median of eight hands", 2),
            panel("the worst of eight hands", 3));
}

void draw_frontier(const std::filesystem::path& directory, const std::vector<FrontierRow>& rows) {
  const std::vector<double> dampings = {0.005, 0.05, 0.2, 0.5, 2.0, 8.0};
  const std::string by_damping = "device damping b [N s/m]";
  draw(
      directory, rows, "frontier_warm",
      "The paper''s wall, 40 kN/m with friction, after 2 s in the air", by_damping, dampings,
      [](const FrontierCase& c, double b) {
        return c.task == "wall" && c.damping == b && c.delay == 0.0 && !c.cold &&
               c.device.name == "simulated";
      },
      4e4);
  draw(
      directory, rows, "frontier_cold",
      "The first press of a cable-driven device (75 g): a wall of 5 kN/m", by_damping, dampings,
      [](const FrontierCase& c, double b) {
        return c.task == "press" && c.damping == b && c.delay == 0.0 && c.cold &&
               c.device.name == "cable_driven";
      },
      5e3);
  draw(
      directory, rows, "frontier_late",
      "Forces that come late: a wall of 40 kN/m, b = 0.5 N s/m, after 2 s in the air",
      "round trip [ms]", {0.0, 5.0, 20.0, 50.0},
      [](const FrontierCase& c, double ms) {
        return c.task == "press" && c.damping == 0.5 && std::abs(c.delay * kMilli - ms) < 1e-6 &&
               !c.cold && c.device.name == "simulated";
      },
      4e4);
}

}  // namespace

void write_rows(const std::filesystem::path& directory, const std::vector<FrontierRow>& rows) {
  const Costs costs = step_costs(rows);
  std::filesystem::create_directories(directory);
  Json list = Json::array();
  for (const FrontierRow& row : rows)
    list.push_back(json(row, costs.at({row.made.law, row.made.need})));
  write_text(directory / "frontier.json", list.dump(0) + '\n');
  write_text(directory / "frontier.csv", csv(rows));
}

std::vector<FrontierRow> write_frontier(const std::filesystem::path& directory,
                                        const std::vector<FrontierCase>& cases) {
  auto rows = run_frontier(cases);
  write_rows(directory, rows);
  draw_frontier(directory, rows);
  return rows;
}

std::string frontier_table(const std::vector<FrontierRow>& rows) {
  std::string text =
      "What is displayed of the commanded stiffness: the median over the hands, the worst hand, "
      "and "
      "how many\nhands are calm (below 10 um). A hand that swings counts as 0; over curved things "
      "and in "
      "taps all hands count.\n";
  struct Block {
    const char* title;
    Picks picks;
  };
  const auto block = [](const char* task, const char* device, double wall, double delay,
                        bool cold) -> Picks {
    return [=](const FrontierCase& c) {
      return c.task == task && c.device.name == device && c.wall == wall && c.delay == delay &&
             c.cold == cold;
    };
  };
  const std::vector<Block> blocks = {
      {"The paper's wall, 40 kN/m with friction, warm, in process",
       block("wall", "simulated", 4e4, 0.0, false)},
      {"First press, cable-driven, 1 kN/m, in process",
       block("press", "cable_driven", 1e3, 0.0, true)},
      {"First press, cable-driven, 5 kN/m, in process",
       block("press", "cable_driven", 5e3, 0.0, true)},
      {"First press, cable-driven, 40 kN/m, in process",
       block("press", "cable_driven", 4e4, 0.0, true)},
      {"40 kN/m, round trip 5 ms, cold", block("press", "simulated", 4e4, 5e-3, true)},
      {"40 kN/m, round trip 20 ms, cold", block("press", "simulated", 4e4, 20e-3, true)},
      {"Taps on 40 kN/m, cold, in process", block("tap", "simulated", 4e4, 0.0, true)},
      {"30 s on 40 kN/m with a tremor of 0.1 mm, in process",
       block("tremor", "simulated", 4e4, 0.0, true)},
      {"Corner of 5 kN/m, in process", block("corner", "simulated", 5e3, 0.0, true)},
      {"Corner of 5 kN/m, round trip 5 ms", block("corner", "simulated", 5e3, 5e-3, true)},
      {"Edge of 5 kN/m, in process", block("edge", "simulated", 5e3, 0.0, true)},
      {"Sphere of 5 kN/m, in process", block("sphere", "simulated", 5e3, 0.0, true)},
      {"Sphere of 5 kN/m, round trip 5 ms", block("sphere", "simulated", 5e3, 5e-3, true)}};
  for (const Block& b : blocks) {
    append(text, "\n%s\n  %-9s", b.title, "b");
    struct Named {
      std::string law;
      Need need;
    };
    const std::vector<Named> laws = {
        {"none", Need::no_account},          {"contact_frame", Need::no_account},
        {"credited", Need::inertia},         {"credited", Need::inertia_friction},
        {"midpoint", Need::unknown_hand},    {"midpoint", Need::inertia},
        {"midpoint", Need::inertia_friction}};
    for (const Named& l : laws)
      append(text, " | %-20s",
             (l.law + (l.need == Need::inertia            ? " mass"
                       : l.need == Need::inertia_friction ? " mass+dry"
                                                          : ""))
                 .c_str());
    for (const double damping : {0.005, 0.05, 0.2, 0.5, 2.0, 8.0}) {
      std::string line;
      bool any = false;
      for (const Named& l : laws) {
        const OverHands o = over_hands(rows, [&](const FrontierCase& c) {
          return b.picks(c) && c.damping == damping && c.law == l.law && c.need == l.need;
        });
        any = any || o.hands > 0;
        if (o.hands == 0)
          append(line, " | %20s", "");
        else
          append(line, " | %5.3f %5.3f %3zu of %zu", o.median, o.worst, o.calm, o.hands);
      }
      if (any) append(text, "\n  %-9g%s", damping, line.c_str());
    }
    text += '\n';
  }
  text +=
      "\nThe cap of the account, simulated device, b = 0.5: what a command gives that pushes the "
      "hand "
      "on\nwhatever way it goes, and what the usual hand is shown of 40 kN/m\n"
      "  cap [needs, mJ] | given [mJ] | speed [m/s] | wall  | taps\n";
  for (const CapRow& row : cap_trade())
    append(text, "  %5g   %6.1f | %10.1f | %11.2f | %5.3f | %5.3f\n", row.cap, row.energy * kMilli,
           row.given * kMilli, row.speed, row.wall, row.taps);
  return text;
}

std::string sessions_table(const std::vector<FrontierRow>& rows) {
  std::string text =
      "\nWhole sessions of `shaped` with a local model, b = 0.5, warm: displayed share, median and "
      "worst hand, and how many hands are calm\n"
      "  task     |       in process        |          50 ms          |         100 ms\n";
  for (const char* task : {"wall", "tap", "sphere", "bunny"}) {
    append(text, "  %-8s", task);
    for (const double delay : {0.0, 50e-3, 100e-3}) {
      const OverHands o = over_hands(rows, [&](const FrontierCase& c) {
        return c.session && c.task == task && c.delay == delay;
      });
      append(text, " | %7.3f %6.3f %2zu of %2zu", o.median, o.worst, o.calm, o.hands);
    }
    text += '\n';
  }
  return text;
}

}  // namespace feltwire
