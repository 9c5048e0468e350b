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
#include "core/bounding/energy_tank.hpp"
#include "core/bounding/none.hpp"
#include "core/bounding/passivity_control.hpp"
#include "core/bounding/per_axis.hpp"
#include "core/bounding/per_axis_projected.hpp"
#include "core/bounding/step.hpp"
#include "core/bounding/total_energy.hpp"
#include "core/bounding/virtual_coupling.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

enum class BoundingMode {
  none,
  total_energy,
  per_axis,
  per_axis_projected,
  contact_frame,
  virtual_coupling,
  passivity_control,
  passivity_control_parallel,
  passivity_control_directional,
  energy_tank
};

inline constexpr std::array<std::string_view, 10> kBoundingModeNames = {
    "none",
    "total_energy",
    "per_axis",
    "per_axis_projected",
    "contact_frame",
    "virtual_coupling",
    "passivity_control",
    "passivity_control_parallel",
    "passivity_control_directional",
    "energy_tank"};
inline constexpr std::array<std::string_view, 2> kProjectionNames = {"joint", "cone"};
inline constexpr std::array<std::string_view, 2> kStorageNames = {"minimal", "elastic"};
inline constexpr std::array<std::string_view, 2> kPassivityReferenceNames = {"zero", "following"};

std::string_view name(BoundingMode mode);
std::string_view name(Projection projection);
std::string_view name(Storage storage);
std::string_view name(PassivityReference reference);
/// Throw std::invalid_argument naming the choices when there is no such mode, projection, storage,
/// reference.
BoundingMode bounding_mode(std::string_view name);
Projection projection(std::string_view name);
Storage storage(std::string_view name);
PassivityReference passivity_reference(std::string_view name);

/// Whether the method asks the scene elsewhere than at the device (Bounding::probe), and so has to
/// stand beside the scene.
bool moves_probe(BoundingMode mode);

/// The virtual coupling of one port; what is not given is the stiffest that is passive.
struct CouplingConfig {
  std::optional<double> stiffness;  // k [N/m]; default b/T
  std::optional<double> damping;    // b_c [N s/m]; default b - k T / 2, all that is allowed
  double mass = 0.05;               // [kg] of the tool, > 0
};

/// Whether what the mode lets through may be reduced further, by whatever factor and for whatever
/// reason, and the port stays passive when the bound is told (set_held). True of bounds on
/// magnitudes from above, and where nothing is bounded.
bool admits_reduction(BoundingMode mode) noexcept;

struct BoundingConfig {
  BoundingMode mode = BoundingMode::contact_frame;
  Projection projection = Projection::joint;                // contact_frame only
  Storage storage = Storage::minimal;                       // contact_frame only
  PassivityReference reference = PassivityReference::zero;  // passivity_control* only
  CouplingConfig coupling{};                                // virtual_coupling only
  CouplingConfig coupling_rotation{{}, {}, 5e-5};           // [N m/rad], [N m s/rad], [kg m^2]
  double period = 1e-3;  // T [s], > 0: the longest time that one force is meant to be held
  Damping damping{};     // B [N s/m]: the device's own, plus any operator credit. contact_frame and
                         // energy_tank need every direction damped, or none
  Damping rotational_damping{};      // B_r [N m s/rad]
  std::optional<double> c1{}, c2{};  // [N/m] translation, paper's modes; default b/T; 0 <= c2 <= c1
  std::optional<double> c1_rotation{}, c2_rotation{};           // [N m/rad] default b_r/T
  double max_force = std::numeric_limits<double>::infinity();   // [N], > 0: peak of the device
  double max_torque = std::numeric_limits<double>::infinity();  // [N m], >= 0
  bool rotation = false;  // false: torque is neither computed nor rendered
};

/// [N], [N m] a command with a component beyond it is refused.
inline constexpr double kLargestForce = 1e12;

/// One step's outcome.
template <class Real>
struct BasicBounded {
  BasicCommand<Real> rendered;  // what the hand is to be given until the next step
  bool active = false;  // the bound changed the command (saturation and refused input not counted)
  bool saturated = false;  // max_force or max_torque scaled it down
  bool refused = false;    // an input was not finite or absurd: zero is rendered
  bool in_debt = false;    // contact_frame, energy_tank: an overlong hold or a foreign force
                           // overdrew; no force until it is repaid
};
using Bounded = BasicBounded<double>;

/// A bounding method with its memory, in arithmetic of `Real`. Nothing here allocates, throws
/// (after construction) or reads a clock.
template <class Real>
class BasicBounding {
 public:
  using Step = BasicBoundingStep<Real>;

  /// Throws std::invalid_argument naming the parameter and the remedy.
  explicit BasicBounding(const BoundingConfig& config);

  /// One servo sample. The order of calls is the order of the samples.
  BasicBounded<Real> step(const Step& step) noexcept;

  /// Says what the device really held after the last step, where that differs from `rendered` (a
  /// fade, a slew limit, a device fault, a skipped write). Only this is accounted in the next step;
  /// the last call before it counts. A report that is not finite or absurd says nothing and is left
  /// out.
  void set_held(const BasicCommand<Real>& held) noexcept;

  /// Of contact_frame: the next step's elastic channel may draw on `energy` [J] beside what it
  /// stores. The bound trusts that the port has that much: the caller sees to it
  /// (core/bounding/port_guard.hpp). Without effect in the other modes.
  void endow(Real energy) noexcept;

  /// Where to ask the scene for the next step's command, relative to the device, which has moved by
  /// `displacement`, `rotation` since the last step. Zero but for the modes that moves_probe().
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept;

  const BoundingConfig& config() const { return config_; }

 private:
  Step checked(const Step& given, bool& refused) const noexcept;
  bool saturate(BasicCommand<Real>& rendered) const noexcept;

  BoundingConfig config_;
  Real period_, max_force_, max_torque_;
  bool rotation_;
  Metric<Real> translation_damping_, rotational_damping_;
  BasicCommand<Real> held_;
  std::variant<NoBound<Real>, TotalEnergyBound<Real>, PerAxisBound<Real>, ProjectedBound<Real>,
               ContactFrameBound<Real>, VirtualCoupling<Real>, PassivityControl<Real>,
               PassivityControlParallel<Real>, PassivityControlDirectional<Real>,
               EnergyTankBound<Real>>
      method_;
};

extern template class BasicBounding<double>;
extern template class BasicBounding<float>;
using Bounding = BasicBounding<double>;

}  // namespace feltwire
