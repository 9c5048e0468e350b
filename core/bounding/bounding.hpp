#pragma once
// The bounding stage: takes the command of the environment, returns the force for the hand.
//
// Source: J. Kim, J.-P. Kim, C. Seo, J. Ryu, "Directionally Transparent Energy Bounding Approach
// for Multiple Degree-of-Freedom Haptic Interaction". Each method has a file in this
// folder and an entry in built_in_methods.hpp; docs/bounding.md has the conventions.

#include "core/bounding/limits.hpp"
#include "core/bounding/method.hpp"
#include "core/bounding/metric.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// The result of a step.
template <class Real>
struct BasicBounded {
  BasicCommand<Real> rendered;  // the command for the hand until the next step
  bool active = false;  // the bound changed the command (saturation and refused input not counted)
  bool saturated = false;  // max_force or max_torque scaled it down
  bool refused = false;    // an input was not finite or out of range: zero is rendered
  bool in_debt = false;    // contact_frame, energy_tank: an overlong hold or a foreign force
                           // overdrew; no force until it is repaid
};
using Bounded = BasicBounded<double>;

/// A bounding method with its memory, in arithmetic of `Real`. Nothing here allocates, throws
/// (after construction) or reads a clock. bounding_template.hpp has the definitions, for
/// arithmetics other than double.
template <class Real>
class BasicBounding {
 public:
  using Step = BasicBoundingStep<Real>;

  /// The method that config.mode names in the registry, which is for double only. Throws
  /// std::invalid_argument naming the parameter and the remedy.
  explicit BasicBounding(const BoundingConfig& config);
  /// A method that need not be in the registry; config.mode is not read. Throws the same.
  BasicBounding(const BasicBoundingMethod<Real>& method, const BoundingConfig& config);

  /// Takes a servo sample. The order of calls is the order of the samples.
  BasicBounded<Real> step(const Step& step) noexcept;

  /// Sets the force that the device really held after the last step, if it differs from `rendered`
  /// (a fade, a slew limit, a device fault, a skipped write). The next step accounts only for this
  /// force. The last call before that step counts. A value that is not finite or out of range is
  /// ignored.
  void set_held(const BasicCommand<Real>& held) noexcept;

  /// For contact_frame: the elastic channel of the next step may use `energy` [J] in addition to
  /// its store. The caller must know that the port has that much (core/bounding/account.hpp). No
  /// effect in the other modes.
  void endow(Real energy) noexcept;
  /// Whether endow() has an effect.
  bool takes_endowment() const noexcept { return law_.takes_endowment(); }

  /// The place in the scene for the next step's command, relative to the device. The device moved
  /// by `displacement`, `rotation` since the last step. Zero, except for modes that move the probe.
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept;

  /// The surfaces change with the next step. `credited` and `shaped` then forget the stiffness of
  /// the scene (BoundingConfig::stiffness), but keep their estimates of the hand.
  void scene_changed() noexcept { law_.scene_changed(); }

  /// The damping that is credited to the hand; only the methods `credited` and `shaped` have it.
  std::optional<HandCredit> hand_credit() const noexcept { return law_.hand_credit(); }

  /// The configuration that it was made with; `mode` is the method's name.
  const BoundingConfig& config() const { return config_; }

 private:
  Step checked(const Step& given, bool& refused) const noexcept;
  BasicBounded<Real> bounded(const Step& s, bool refused) noexcept;
  bool saturate(BasicCommand<Real>& rendered) const noexcept;

  BoundingConfig config_;
  Real period_, max_force_, max_torque_;
  bool rotation_;
  Metric<Real> translation_damping_, rotational_damping_;
  BasicCommand<Real> held_;
  BasicBoundingLaw<Real> law_;
};

template <>
BasicBounding<double>::BasicBounding(const BoundingConfig& config);
extern template class BasicBounding<double>;
using Bounding = BasicBounding<double>;

}  // namespace feltwire
