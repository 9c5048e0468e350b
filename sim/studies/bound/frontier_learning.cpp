// Measures the benefit if the energy account learns how strong the hand is (--learn-hand-force).

#include <array>

#include "core/base/text.hpp"
#include "sim/studies/bound/frontier.hpp"
#include "sim/studies/bound/over_hands.hpp"

namespace feltwire {
namespace {

constexpr double kMinute = 60.0;  // [s] duration of a run; only its second half is measured

struct Knowledge {
  const char* title;
  double hand_force;  // [N] assumed largest force of the hand
  bool learns;
};
constexpr std::array kKnowledge = {Knowledge{"told 10 N", kHandForce, false},
                                   Knowledge{"learns", kHandForce, true},
                                   Knowledge{"told 5 N", 0.5 * kHandForce, false}};
constexpr std::array kLearningTasks = {"press", "wall", "tap"};
constexpr std::array kLearningDampings = {0.005, 0.05, 0.5};
constexpr std::array kLearningWalls = {5e3, 4e4};

}  // namespace

std::vector<FrontierCase> learning_cases() {
  std::vector<FrontierCase> cases;
  for (const char* task : kLearningTasks)
    for (const double damping : kLearningDampings)
      for (const double wall : kLearningWalls)
        for (const NamedHand& hand : kEightHands)
          for (const Knowledge& known : kKnowledge)
            cases.push_back({.task = task,
                             .law = "midpoint",
                             .need = Need::inertia,
                             .damping = damping,
                             .device = kFrontierDevices[1],
                             .wall = wall,
                             .hand = hand,
                             .hand_force = known.hand_force,
                             .learns = known.learns,
                             .duration = kMinute});
  return cases;
}

std::string learning_table(const std::vector<FrontierRow>& rows) {
  std::string text =
      "\nLearning the hand's force (cable-driven device, its mass known, a minute of which the "
      "second half\ncounts): displayed, the median and the worst hand, how many are calm, and "
      "samples in debt\n  task  wall   b    ";
  for (const Knowledge& known : kKnowledge) append(text, " | %-27s", known.title);
  for (const char* task : kLearningTasks)
    for (const double wall : kLearningWalls)
      for (const double damping : kLearningDampings) {
        append(text, "\n  %-5s %5g %-6g", task, wall, damping);
        for (const Knowledge& known : kKnowledge) {
          const auto picked = [&](const FrontierCase& c) {
            return c.task == task && c.wall == wall && c.damping == damping &&
                   c.hand_force == known.hand_force && c.learns == known.learns;
          };
          const OverHands o = over_hands(rows, picked);
          std::uint64_t debts = 0;
          for (const FrontierRow& row : rows) debts += picked(row.made) ? row.excess : 0;
          append(text, " | %5.3f %5.3f %zu of %zu %6llu", o.median, o.worst, o.calm, o.hands,
                 static_cast<unsigned long long>(debts));
        }
      }
  return text + '\n';
}

}  // namespace feltwire
