#pragma once
// Internal to core/arm, and to who simulates an arm alone: what a DrivenArm consists of.

#include "core/arm/arm_parts.hpp"
#include "core/arm/driven_arm.hpp"
#include "core/arm/impedance.hpp"

namespace feltwire {

struct DrivenArm::Inside {
  Inside(const ArmControl& numbers, const std::string& file, const mjModel& of, const mjData& data)
      : control(numbers),
        model(of),
        parts(arm::find_arm(of, file, numbers.prefix)),
        impedance(control, parts, of, data) {}

  const ArmControl control;
  const mjModel& model;
  const arm::ArmParts parts;
  arm::Impedance impedance;
  FollowerSpec spec;
  FollowerReading reading;
  Mat3 wrist = Mat3::Identity();                     // of the step's beginning
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // on the tool, without noise
};

}  // namespace feltwire
