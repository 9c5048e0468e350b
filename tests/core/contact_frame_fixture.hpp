#pragma once
// The device, the period and the bound that the contact frame's tests share.

#include "tests/core/support.hpp"

namespace feltwire::test {

inline constexpr double kPeriod = 1e-3;                       // [s]
inline constexpr double kDamping = 0.5;                       // [N s/m]
inline constexpr double kRotationalDamping = 2e-4;            // [N m s/rad]
inline constexpr double kColgate = 2.0 * kDamping / kPeriod;  // [N/m]

inline BoundingConfig contact_frame(Projection projection = Projection::joint,
                                    Storage storage = Storage::minimal) {
  return {.mode = "contact_frame",
          .projection = projection,
          .storage = storage,
          .period = kPeriod,
          .damping = kDamping,
          .rotational_damping = kRotationalDamping,
          .c1 = {},
          .c2 = {},
          .c1_rotation = {},
          .c2_rotation = {},
          .rotation = true};
}

}  // namespace feltwire::test
