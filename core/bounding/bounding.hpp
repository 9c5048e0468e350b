#pragma once
// The bounding stage: between what the environment commands and what the hand is given.
//
// Source: J. Kim, J.-P. Kim, C. Seo, J. Ryu, "Directionally Transparent Energy Bounding Approach
// for Multiple Degree-of-Freedom Haptic Interaction". One file a method beside this one;
// conventions in docs/bounding.md.

#include <array>
#include <limits>
#include <optional>
#include <string_view>
#include <variant>

#include "core/bounding/contact_frame.hpp"
#include "core/bounding/none.hpp"
#include "core/bounding/per_axis.hpp"
#include "core/bounding/per_axis_projected.hpp"
#include "core/bounding/step.hpp"
#include "core/bounding/total_energy.hpp"

namespace feltwire {

enum class BoundingMode { none, total_energy, per_axis, per_axis_projected, contact_frame };

inline constexpr std::array<std::string_view, 5> kBoundingModeNames = {
    "none", "total_energy", "per_axis", "per_axis_projected", "contact_frame"};
inline constexpr std::array<std::string_view, 2> kProjectionNames = {"joint", "cone"};
inline constexpr std::array<std::string_view, 2> kStorageNames = {"minimal", "elastic"};

std::string_view name(BoundingMode mode);
std::string_view name(Projection projection);
std::string_view name(Storage storage);
/// Throw std::invalid_argument naming the choices when there is no such mode, projection, storage.
BoundingMode bounding_mode(std::string_view name);
Projection projection(std::string_view name);
Storage storage(std::string_view name);

struct BoundingConfig {
  BoundingMode mode = BoundingMode::contact_frame;
  Projection projection = Projection::joint;  // contact_frame only
  Storage storage = Storage::minimal;         // contact_frame only
  double period = 1e-3;  // T [s], > 0: the longest time that one force is meant to be held
  double damping = 0.0;  // b [N s/m], >= 0: the device's own, plus any operator credit
  double rotational_damping = 0.0;  // b_r [N m s/rad], >= 0
  std::optional<double> c1, c2;     // [N/m] translation, paper's modes; default b/T; 0 <= c2 <= c1
  std::optional<double> c1_rotation, c2_rotation;               // [N m/rad] default b_r/T
  double max_force = std::numeric_limits<double>::infinity();   // [N], > 0: peak of the device
  double max_torque = std::numeric_limits<double>::infinity();  // [N m], >= 0
  bool rotation = false;  // false: torque is neither computed nor rendered
};

/// One step's outcome.
struct Bounded {
  Command rendered;     // what the hand is to be given until the next step
  bool active = false;  // the bound changed the command (saturation and refused input not counted)
  bool saturated = false;  // max_force or max_torque scaled it down
  bool refused = false;    // an input was not finite or absurd: zero is rendered
  bool in_debt = false;    // contact_frame: an overlong hold or a foreign force overdrew; no force
                           // until it is repaid
};

/// A bounding method with its memory. Nothing here allocates, throws (after construction) or reads
/// a clock.
class Bounding {
 public:
  /// Throws std::invalid_argument naming the parameter and the remedy.
  explicit Bounding(const BoundingConfig& config);

  /// One servo sample. The order of calls is the order of the samples.
  Bounded step(const BoundingStep& step) noexcept;

  /// Says what the device really held after the last step, where that differs from `rendered` (a
  /// fade, a slew limit, a device fault, a skipped write). Only this is accounted in the next step;
  /// the last call before it counts. A report that is not finite or absurd says nothing and is left
  /// out.
  void set_held(const Command& held) noexcept;

  const BoundingConfig& config() const { return config_; }

 private:
  BoundingConfig config_;
  Command held_;
  std::variant<NoBound, TotalEnergyBound, PerAxisBound, ProjectedBound, ContactFrameBound> method_;
};

}  // namespace feltwire
