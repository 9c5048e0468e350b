// The cases of the frontier: which law, hand, device, wall and delay run together.

#include <array>

#include "sim/published_laws/published_laws.hpp"
#include "sim/studies/bound/frontier.hpp"

namespace feltwire {
namespace {

constexpr double kStiffEnough = 150.0;  // [N/m] softer hands run only the tasks of on_wall()

struct Law {
  const char* name;
  Need need;
};
constexpr std::array kNear = {Law{"midpoint", Need::unknown_hand}, Law{"midpoint", Need::inertia},
                              Law{"midpoint", Need::inertia_friction}};
constexpr std::array kEverywhere = {
    Law{"none", Need::no_account}, Law{"contact_frame", Need::no_account},
    Law{"credited", Need::inertia}, Law{"credited", Need::inertia_friction}};

/// Adds a case for each law. The midpoint law needs a force without delay, so it has cases only
/// without delay.
void add_laws(std::vector<FrontierCase>& cases, FrontierCase c) {
  const auto add = [&](const auto& laws) {
    for (const Law& law : laws) {
      c.law = law.name;
      c.need = law.need;
      cases.push_back(c);
    }
  };
  add(kEverywhere);
  if (c.delay == 0.0) add(kNear);
}

/// Adds a case for each law of other papers, and for the virtual coupling. These laws run without
/// an energy account.
void add_published(std::vector<FrontierCase>& cases, FrontierCase c) {
  c.need = Need::no_account;
  for (const BoundingMethod& published : published_laws()) {
    c.law = published.name;
    cases.push_back(c);
  }
  c.law = "virtual_coupling";
  cases.push_back(c);
}

}  // namespace

std::vector<FrontierCase> session_cases() {
  std::vector<FrontierCase> cases;
  for (const char* task : {"wall", "tap", "sphere", "bunny"})
    for (const double delay : {0.0, 50e-3, 100e-3})
      for (const NamedHand& hand : kEightHands) {
        const FrontierCase c{.task = task,
                             .law = "shaped",
                             .need = Need::inertia_friction,
                             .delay = delay,
                             .hand = hand,
                             .cold = false,
                             .session = true};
        if (on_wall(c.task) || hand.hand.stiffness >= kStiffEnough) cases.push_back(c);
      }
  return cases;
}

std::vector<FrontierCase> published_cases() {
  struct PublishedTask {
    const char* task;
    double delay;  // [s] round trip
  };
  constexpr std::array kOnWalls = {PublishedTask{"wall", 0.0}, PublishedTask{"tap", 0.0},
                                   PublishedTask{"press", 5e-3}, PublishedTask{"press", 20e-3}};
  std::vector<FrontierCase> cases;
  for (const PublishedTask& where : kOnWalls)
    for (const double damping : {0.05, 0.5, 2.0, 8.0})
      for (const double wall : {5e3, 4e4})
        for (const NamedHand& hand : kEightHands)
          for (const bool cold : {true, false})
            add_published(cases, {.task = where.task,
                                  .damping = damping,
                                  .wall = wall,
                                  .delay = where.delay,
                                  .hand = hand,
                                  .cold = cold});
  for (const double damping : {0.05, 0.5, 2.0, 8.0})
    for (const double delay : {0.0, 5e-3})
      for (const NamedHand& hand : kEightHands) {
        if (hand.hand.stiffness < kStiffEnough) continue;
        add_published(
            cases,
            {.task = "sphere", .damping = damping, .wall = 5e3, .delay = delay, .hand = hand});
      }
  return cases;
}

std::vector<FrontierCase> frontier_cases() {
  constexpr std::array kDampings = {0.005, 0.05, 0.2, 0.5, 2.0, 8.0};
  constexpr std::array kDelays = {0.0, 5e-3, 20e-3, 50e-3};
  constexpr std::array kWalls = {1e3, 5e3, 4e4};
  std::vector<FrontierCase> cases;
  FrontierCase c;
  for (const char* task : {"wall", "press", "tap", "tremor"})
    for (const FrontierDevice& device : kFrontierDevices)
      for (const double damping : kDampings)
        for (const double wall : kWalls)
          for (const double delay : kDelays)
            for (const NamedHand& hand : kEightHands)
              for (const bool cold : {true, false}) {
                c = {.task = task,
                     .damping = damping,
                     .device = device,
                     .wall = wall,
                     .delay = delay,
                     .hand = hand,
                     .cold = cold};
                // A run with tremor simulates 30 s, so most of these cases are left out.
                const bool pressed_long = c.task == "tremor";
                if (pressed_long && (wall != 4e4 || delay > 0.0 || damping < 0.5)) continue;
                add_laws(cases, c);
              }
  for (const char* task : {"sphere", "corner", "edge", "torus", "stick_slip"})
    for (const double damping : kDampings)
      for (const double delay : kDelays)
        for (const NamedHand& hand : kEightHands) {
          if (hand.hand.stiffness < kStiffEnough) continue;
          add_laws(cases,
                   {.task = task, .damping = damping, .wall = 5e3, .delay = delay, .hand = hand});
        }
  const auto published = published_cases();
  cases.insert(cases.end(), published.begin(), published.end());
  const auto sessions = session_cases();
  cases.insert(cases.end(), sessions.begin(), sessions.end());
  return cases;
}

}  // namespace feltwire
