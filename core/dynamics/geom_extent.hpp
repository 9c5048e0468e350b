#pragma once
// Internal to core/dynamics: where the geoms of a model are, how thick they are, and which of them
// can meet.

#include <mujoco/mujoco.h>

#include "core/base/types.hpp"

namespace feltwire::mujoco {

/// Half the extent [m] of a geom along a direction in the world frame.
double half_extent_along(const mjModel& model, const mjData& data, int geom, const Vec3& along);

/// Half the least extent [m] of a geom. Each primitive is thinnest along one of its axes. This is
/// nearly true for a mesh too, because MuJoCo aligns a mesh with its principal axes of inertia.
double half_thickness(const mjModel& model, int geom);

/// Whether gravity moves a body: the body or one of its parents is free, or slides along `up`.
bool falls(const mjModel& model, const mjData& data, int body, const Vec3& up);

/// Whether two geoms can touch: they are of different bodies, and their masks allow it.
bool meet(const mjModel& model, int a, int b);

/// Whether the vertical projections of two geoms may overlap.
bool overlap(const mjModel& model, const mjData& data, int a, int b, const Vec3& up);

/// The time constant [s] of the contact between two geoms.
double contact_time(const mjModel& model, int a, int b);

}  // namespace feltwire::mujoco
