#pragma once
// A tool with a body that a client has in full, with still solids of its scene. With them the
// client finds the tool's balance, or its movement, as the server does, over every delay.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/shapes.hpp"
#include "core/geometry/triangle_soup.hpp"
#include "core/local_model/trial_way.hpp"
#include "core/material/material.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// Immutable. What it is made of never allocates when it is asked.
struct PrefetchedTool {
  std::uint32_t version = 0;             // of tool and solids together; never 0
  std::vector<std::uint16_t> objects{};  // the numbers of the solids in the scene, as they came
  ToolCoupling coupling;                 // nothing in it is zero
  double radius = 0.0;                   // [m] of the tool's farthest point from its origin
  ToolInertia inertia;                   // of mass 0: it has none
  std::unique_ptr<const ToolSurroundings> solids;  // never null
  std::vector<TrialWay> ways;  // on which a contact is likely to cost the most, for try_contact()
};

/// The most points of a tool that travels: a client looks at them with every tick.
inline constexpr std::size_t kMostBodyPoints = 20'000;

/// A tool with a body, as it travels.
struct BodyData {
  ToolCoupling coupling;      // nothing in it is zero
  ToolInertia inertia;        // of mass 0: it has none
  double contact_area = 0.0;  // [m^2] A_c of add_contact()
  double area = 0.0;          // [m^2] of the whole surface; each point stands for the same share
  std::vector<Vec3> points;   // [m, tool frame]
};

/// A still solid, as it travels.
struct SolidData {
  std::uint16_t object = 0;  // its number in the scene
  Shape shape;               // a primitive, if there are no triangles
  TriangleSoup mesh = {};    // [m, object frame] felt as its grid (grid_for_body()); or empty
  bool from_inside = false;
  Pose pose;  // [m, world]
  Material material;
};

}  // namespace feltwire
