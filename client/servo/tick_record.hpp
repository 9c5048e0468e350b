#pragma once
// The record of one servo tick.

#include "core/base/types.hpp"

namespace feltwire {

/// One row of a recording: t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age.
struct TickRecord {
  double time = 0.0;               // t [s] since the first tick
  Vec3 position = Vec3::Zero();    // x,y,z [m]
  Vec3 elastic = Vec3::Zero();     // ex.. [N] of the newest command of the environment, on the hand
  Vec3 frictional = Vec3::Zero();  // fx.. [N] likewise
  Vec3 held = Vec3::Zero();        // rx.. [N] what the hand was given from here on
  double age = -1.0;               // [s] of the command; -1 before the first
};

}  // namespace feltwire
