#include <algorithm>
#include <array>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/studies/bound/over_hands.hpp"

namespace feltwire {
namespace {

struct PublishedLaw {
  const char *name, *title;
  Need need = Need::no_account;
};
/// The laws of this project come first, then the laws of other papers.
constexpr std::array kPublishedLaws = {
    PublishedLaw{"none", "none"},
    PublishedLaw{"contact_frame", "contact_frame"},
    PublishedLaw{"midpoint", "shaped, near + account", Need::inertia_friction},
    PublishedLaw{"credited", "shaped, late + account", Need::inertia_friction},
    PublishedLaw{"tdpc_exact", "tdpc_exact"},
    PublishedLaw{"bounded_output", "bounded_output"},
    PublishedLaw{"force_augmentation", "force_augmentation"},
    PublishedLaw{"force_augmentation_transient", "... with its transient"},
    PublishedLaw{"position_memory", "position_memory"},
    PublishedLaw{"two_layer_tank", "two_layer_tank"},
    PublishedLaw{"virtual_coupling", "virtual_coupling"}};

struct Place {
  const char *title, *task;
  double wall, delay;  // [N/m] stiffness of the wall, [s] round trip
  bool cold;
};
constexpr std::array kPlaces = {
    Place{"The paper's wall, 40 kN/m with friction, after 2 s in the air", "wall", 4e4, 0.0, false},
    Place{"The same, cold", "wall", 4e4, 0.0, true},
    Place{"A wall of 5 kN/m with friction, cold", "wall", 5e3, 0.0, true},
    Place{"The sphere, 5 kN/m", "sphere", 5e3, 0.0, true},
    Place{"The sphere, round trip 5 ms", "sphere", 5e3, 5e-3, true},
    Place{"Taps on 40 kN/m, cold", "tap", 4e4, 0.0, true},
    Place{"A press on 40 kN/m, round trip 5 ms, cold", "press", 4e4, 5e-3, true},
    Place{"A press on 40 kN/m, round trip 20 ms, cold", "press", 4e4, 20e-3, true}};

}  // namespace

std::string published_table(const std::vector<FrontierRow>& rows) {
  std::string text =
      "\nLaws of other papers beside ours, on the simulated device; median and worst of the hands. "
      "displayed: a hand\nthat swings by 10 um or more counts as 0, but over the sphere and in "
      "taps. energy: the most that a hand got\nbeyond what the device burned.\n";
  for (const Place& place : kPlaces) {
    append(text, "\n%s\n", place.title);
    append(text, "  b [N s/m]  %-22s  displayed       oscillation [um]    energy    calm\n", "law");
    for (const double damping : {0.05, 0.5, 2.0, 8.0})
      for (const PublishedLaw& law : kPublishedLaws) {
        const OverHands o = over_hands(rows, [&](const FrontierCase& c) {
          return c.task == place.task && c.wall == place.wall && c.delay == place.delay &&
                 c.cold == place.cold && c.damping == damping && c.law == law.name &&
                 c.need == law.need && c.device.name == kFrontierDevices[0].name;
        });
        if (o.hands == 0) continue;
        append(text, "  %-9g  %-22s  %6.3f %6.3f  %8.1f %8.1f  %8.2f mJ  %zu of %zu\n", damping,
               law.title, o.median, o.worst, o.median_oscillation * kMicro,
               o.worst_oscillation * kMicro, o.energy_made * kMilli, o.calm, o.hands);
      }
  }
  return text;
}

}  // namespace feltwire
