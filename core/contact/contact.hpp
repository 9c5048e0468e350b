#pragma once
// One tool point against one object: penalty force from the proxy, friction from a stick point.

#include <string>

#include "core/contact/contact_law.hpp"
#include "core/contact/material.hpp"
#include "core/contact/shapes.hpp"
#include "core/types.hpp"

namespace feltwire {

struct Object {
  std::string name;
  Shape shape;
  Side felt_from = Side::outside;
  Pose pose;
  Material material;
};

/// The force on the hand (world frame) that the object answers the tool with, by contact_law.hpp;
/// zero and a cleared memory when free. The tool is a point, or a ball where `radius` [m] is above
/// zero.
Command touch(const Object& object, const Tool& tool, ContactMemory& memory,
              double radius = 0.0) noexcept;

/// The same, added to `sum`. False, and nothing added, when free.
bool add_touch(const Object& object, const Tool& tool, ContactMemory& memory, double radius,
               Command& sum) noexcept;

}  // namespace feltwire
