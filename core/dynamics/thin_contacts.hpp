#pragma once
// Bodies so thin and so fast that a tick of the simulation takes them through what they fall onto.

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "core/contact/contact.hpp"

namespace feltwire::mujoco {

/// MuJoCo pushes two bodies apart on the side where they overlap least. A body that comes in by
/// more than half of both thicknesses within the time of a contact is pushed out on the far side.
/// This finds the bodies that fall that fast from where they start onto what lies below them, and
/// says the speed, the speed that they hold, and the remedy. `data`: the model's start, evaluated.
/// `object_of`: the object of each geom; -1: none.
std::vector<std::string> thin_contacts(const mjModel& model, const mjData& data,
                                       const std::vector<Object>& objects,
                                       const std::vector<int>& object_of);

/// [m/s] A hand that moves an object is about this fast: a device reaches 1 to 2 m/s.
inline constexpr double kPushedSpeed = 1.0;

/// Finds the bodies so thin that a hand may push one through the other, with kPushedSpeed. Says the
/// pair that holds the least speed, and the number of the others. Empty: there is no such pair.
std::string thin_pushed_bodies(const mjModel& model, const std::vector<Object>& objects,
                               const std::vector<int>& object_of);

/// [m/s] The speed up to which two bodies, together `thickness` [m] thick, hold each other.
/// `contact` [s] is the time constant of MuJoCo's contacts (solref), `tick` [s] a step.
double held_speed(double thickness, double contact, double tick);

}  // namespace feltwire::mujoco
