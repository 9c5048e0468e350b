// Compares the laws on a realistic plant, for example with motor lag. The energy is measured at the
// true motor and at the handle.

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/hands/amplifier_lag.hpp"
#include "sim/studies/bound/frontier.hpp"
#include "sim/studies/bound/over_hands.hpp"

namespace feltwire {
namespace {

struct JudgedLaw {
  const char* name;
  Need need;
  bool session;
};
constexpr std::array kJudgedLaws = {JudgedLaw{"none", Need::no_account, false},
                                    JudgedLaw{"contact_frame", Need::no_account, false},
                                    JudgedLaw{"credited", Need::inertia_friction, false},
                                    JudgedLaw{"midpoint", Need::inertia_friction, false},
                                    JudgedLaw{"shaped", Need::inertia_friction, true}};
constexpr std::array kPlantTasks = {"press", "tap"};
constexpr std::array kPlantDampings = {0.005, 0.5, 2.0};  // [N s/m]
constexpr std::array kPlantWalls = {1e3, 5e3, 4e4};       // [N/m]

}  // namespace

std::vector<FrontierCase> plant_cases(const Plant& plant, bool told) {
  const auto shared = std::make_shared<const Plant>(for_any_hand(plant));
  std::vector<FrontierCase> cases;
  for (const char* task : kPlantTasks)
    for (const FrontierDevice& device : kFrontierDevices)
      for (const double damping : kPlantDampings)
        for (const double wall : kPlantWalls)
          for (const JudgedLaw& law : kJudgedLaws)
            for (const NamedHand& held : kEightHands)
              cases.push_back({.task = task,
                               .law = law.name,
                               .need = law.need,
                               .damping = damping,
                               .device = device,
                               .wall = wall,
                               .hand = held,
                               .session = law.session,
                               .plant = shared,
                               .told = told ? lag_of(plant.amplifier) : MotorLag{}});
  return cases;
}

std::string plant_table(const std::vector<FrontierRow>& rows) {
  std::string text =
      "On this plant, cold: the median share shown at the handle, how many hands are calm there "
      "(below 10 um), and the most energy\nthat the true motor made beyond its own friction [mJ]. "
      "A hand that swings counts as 0.\n";
  for (const char* task : kPlantTasks)
    for (const FrontierDevice& device : kFrontierDevices) {
      append(text, "\n%s, %s\n  %-6s %-6s", task, std::string(device.name).c_str(), "b", "N/m");
      for (const JudgedLaw& law : kJudgedLaws) append(text, " | %-22s", law.name);
      for (const double damping : kPlantDampings)
        for (const double wall : kPlantWalls) {
          append(text, "\n  %-6g %-6g", damping, wall);
          for (const JudgedLaw& law : kJudgedLaws) {
            const OverHands o = over_hands(rows, [&](const FrontierCase& c) {
              return c.task == task && c.device.name == device.name && c.damping == damping &&
                     c.wall == wall && c.law == law.name;
            });
            append(text, " | %5.3f %zu of %zu %8.3g", o.median, o.calm, o.hands,
                   o.made_at_motor * kMilli);
          }
        }
      text += '\n';
    }
  return text;
}

}  // namespace feltwire
