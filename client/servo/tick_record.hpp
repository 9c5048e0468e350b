#pragma once
// The record of one servo tick.

#include <cstdint>
#include <optional>

#include "client/servo/zero_force_reason.hpp"
#include "core/base/types.hpp"
#include "core/teleoperation/lead_engagement.hpp"

namespace feltwire {

/// A row of a recording. A CSV has t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age; an MCAP file has all.
struct TickRecord {
  double time = 0.0;               // t [s] since the first tick
  Vec3 position = Vec3::Zero();    // x,y,z [m]
  Vec3 elastic = Vec3::Zero();     // ex.. [N] of the newest command of the environment, on the hand
  Vec3 frictional = Vec3::Zero();  // fx.. [N] the same
  Vec3 held = Vec3::Zero();        // rx.. [N] the force on the hand from this tick on
  double age = -1.0;               // [s] age of the command; -1 before the first
  std::int64_t clock = 0;          // [ns] time of the tick, by the servo's clock
  Quaternion orientation = Quaternion::Identity();
  Vec3 torque = Vec3::Zero();       // [N m] the torque on the hand together with `held`
  std::optional<double> balance{};  // [J] balance of the account; empty: there is none
  double account_cut = 0.0;         // share of the command that the account took off
  ZeroForceReason no_force = ZeroForceReason::touches_nothing;  // the reason for no force
  LinkState robot = LinkState::disabled;  // of the hand and the robot that it leads
};

}  // namespace feltwire
