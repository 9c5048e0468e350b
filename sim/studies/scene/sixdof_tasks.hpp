#pragma once
// Tasks in six degrees of freedom, each for tools of points and of polygons.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/tool/body_tool.hpp"
#include "sim/studies/scene/cut_solids.hpp"

namespace feltwire {

/// A tool and the one solid that it touches, without friction.
///
///   peg 0.5, peg 0.1   a box of 20 x 20 x 40 mm sways in a pocket that is so many mm wider
///   gears              a spur gear rolls round another one, its flanks pressed on
///   chain              a link pulls and sways in another one
///   edge               a box of 60 x 40 x 20 mm slides flat over the edge of a table, and back
///   ridge              the edge of a cube is moved over that of another one, 4 mm too low: on the
///                      ridge a tool has no place to rest
///   bunny              the Stanford bunny presses on another one, and slides and turns there
///   bunny 20k          the same with a finer surface
struct SixDofTask {
  std::string name;
  CutSolid tool;
  CutSolid solid;          // empty where it is a box
  std::optional<Box> box;  // the solid, or a pocket: points touch its formula, not a grid
  Side side = Side::outside;
  Pose place;                 // of the solid
  double contact_area = 0.0;  // [m^2]
  /// The device's pose at a share of the task, 0 ... 1. It begins at rest, out of contact.
  std::function<Pose(double)> device;
  Vec3 press = Vec3::Zero();  // unit: pushed this way from the beginning, the tool meets the solid
  double time = 0.5;          // [s]
};

/// Their names, in this order.
std::vector<std::string> sixdof_task_names();

/// `names`: only these tasks; empty: all. `bunny_tolerance` [m]: that of bunny_solid(), and
/// `fine_triangles` of the finer surface; 0: without this task.
std::vector<SixDofTask> sixdof_tasks(double bunny_tolerance, std::size_t fine_triangles = 0,
                                     const std::vector<std::string>& names = {});

/// The solid of a task as what a tool of polygons touches.
SolidParts solid_parts_of(const SixDofTask& task);

/// The solid as what a tool of points touches. A mesh is a grid of distances with `steps` along its
/// longest side.
Object object_of(const SixDofTask& task, double stiffness, double steps);

}  // namespace feltwire
