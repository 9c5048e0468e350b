// Tests guides together with the energy bound. The energy of a guide must not count for a surface
// near the guide.

#include <gtest/gtest.h>

#include <numbers>

#include "core/bounding/bounding.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/scene_file/load_scene.hpp"

namespace feltwire::guide_bound_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
const Damping kDamping(0.5);      // [N s/m] A spring up to 1000 N/m is rendered completely.

constexpr const char* kGroove = R"(
  {"name": "groove", "line": {}, "orientation": [0.7071067811865476, 0.7071067811865476, 0, 0],
   "attract": {"stiffness": 250, "range": 0.015}, "max_force": 1.5})";
constexpr const char* kMagnet = R"(
  {"name": "goal", "point": {}, "position": [0.1, 0.02, 0], "magnet": {"reach": 0.008},
   "max_force": 1})";

Scene board(const std::string& guides) {
  return parse_scene(R"({"name": "board",
    "materials": [{"name": "m", "stiffness": 900, "damping": 0.2,
                   "static_friction": 0.1, "dynamic_friction": 0.08}],
    "objects": [{"name": "board", "plane": {}, "material": "m"}],
    "guides": [)" + guides +
                         "]}",
                     "board.json");
}

struct BoardForces {
  double commanded = 0.0, rendered = 0.0;  // [N] mean force along the board's normal during contact
  double across = 0.0;                     // [N] largest rendered force along the board
  std::uint64_t violations = 0;
};

/// A hand moves down from 5 mm above the board to 3 mm below. Once a second, the hand slides across
/// the groove to and fro.
BoardForces solve_friction(const Scene& scene, const BoundingConfig& config) {
  Bounding bounding(config);
  PortEnergy port(config.damping, config.rotational_damping, kPeriod);
  TouchMemory memory = scene.memory();
  Vec3 before(0.0, 0.0, 0.005);
  Command held;
  BoardForces felt;
  int pressed = 0;
  for (int n = 0; n < 4000; ++n) {
    const double t = kPeriod * n;
    const double down = 0.005 - 0.008 * std::min(1.0, t / 0.5);
    const Vec3 at(0.03 * std::sin(2.0 * std::numbers::pi * t), 0.0, down);
    const Vec3 moved = at - before;
    before = at;
    port.step(held, moved, Vec3::Zero(), kPeriod);
    const Command command = scene.touch({at, moved / kPeriod}, memory);
    held = bounding.step({moved, Vec3::Zero(), kPeriod, command}).rendered;
    if (!(t > 0.5)) continue;
    ++pressed;
    felt.commanded += command.force().z();
    felt.rendered += held.force().z();
    felt.across = std::max(felt.across, held.force().head<2>().norm());
  }
  felt.commanded /= pressed;
  felt.rendered /= pressed;
  felt.violations = port.violations();
  return felt;
}

BoundingConfig contact_frame() {
  BoundingConfig config;
  config.mode = "contact_frame";
  config.projection = Projection::cone;
  config.damping = kDamping;
  config.period = kPeriod;
  return config;
}

TEST(GuideBound, NoSurfaceIsWeakerForAGuideBesideIt) {
  for (const Storage storage : {Storage::minimal, Storage::elastic}) {
    BoundingConfig config = contact_frame();
    config.storage = storage;
    const BoardForces plain = solve_friction(board(""), config);
    EXPECT_GT(plain.rendered, 0.95 * plain.commanded);
    for (const char* guide : {kGroove, kMagnet}) {
      const BoardForces guided = solve_friction(board(guide), config);
      EXPECT_GT(guided.rendered, 0.99 * plain.rendered) << guide;
      EXPECT_GT(guided.rendered, 0.94 * guided.commanded)
          << guided.commanded << " N commanded, " << guided.rendered << " rendered: " << guide;
      // The surface must not weaken the guide either.
      EXPECT_GT(guided.across, plain.across) << guide;
      EXPECT_EQ(guided.violations, 0u);
    }
  }
}

/// The guide pulls harder than the surface pushes. The force must still be the sum, and no contact
/// may pull.
TEST(GuideBound, AGuideMayPullIntoASurface) {
  const Scene scene =
      board(R"({"name": "down", "constant": {"force": [0.3, 0, -2]}, "max_force": 9})");
  for (const double depth : {-0.001, 0.001, 0.002, 0.0023, 0.003, 0.005}) {
    TouchMemory memory = scene.memory();
    const Command command = scene.touch({{0.0, 0.0, -depth}, Vec3::Zero()}, memory);
    const double push = 900.0 * std::max(0.0, depth);
    EXPECT_TRUE(command.force().isApprox(Vec3(0.3, 0.0, push - 2.0), 1e-12)) << depth;
    EXPECT_EQ(command.elastic, push > 2.0 ? Vec3(0.0, 0.0, push) : Vec3(Vec3::Zero())) << depth;
    // The bound must not treat this force as a contact. A hand that moves against the force must
    // get the complete force.
    Bounding bounding(contact_frame());
    const Vec3 against = -0.01 * command.force().normalized();
    const Command felt = bounding.step({against, Vec3::Zero(), kPeriod, command}).rendered;
    EXPECT_TRUE(felt.force().isApprox(command.force(), 1e-12)) << depth;
  }
}

}  // namespace
}  // namespace feltwire::guide_bound_test
