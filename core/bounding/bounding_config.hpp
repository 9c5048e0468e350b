#pragma once
// The configuration of a bound: the method, its options, and the device.

#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "core/device/damping.hpp"

namespace feltwire {

/// For contact_frame: the reduction of the other channels when one is bounded.
enum class Projection {
  joint,  // one factor for elastic and frictional: the command's direction is kept exactly
  cone    // the elastic force keeps its own factor, friction takes the smaller: normal force is not
          // lost to friction
};

/// For contact_frame: the part of the pressed-in energy that stays in the elastic channel.
enum class Storage {
  minimal,  // S(F) of the force held, the least that is safe: a spring softer than c fades on
            // release
  elastic   // also the rest of a spring's energy: every spring up to c returns all its energy
};

/// For passivity_control*: the reference to which the observed energy is compared.
enum class PassivityReference {
  zero,      // Hannaford & Ryu 2002
  following  // Ryu et al. 2005: the energy that the environment takes in continuous time
};

inline constexpr std::array<std::string_view, 2> kProjectionNames = {"joint", "cone"};
inline constexpr std::array<std::string_view, 2> kStorageNames = {"minimal", "elastic"};
inline constexpr std::array<std::string_view, 2> kPassivityReferenceNames = {"zero", "following"};

std::string_view name(Projection projection);
std::string_view name(Storage storage);
std::string_view name(PassivityReference reference);
/// They throw std::invalid_argument that lists the choices if there is no such projection, storage,
/// reference.
Projection projection(std::string_view name);
Storage storage(std::string_view name);
PassivityReference passivity_reference(std::string_view name);

/// The method that changes no command; the default, which is a complete bound on either side; and
/// the usual one of a client, which needs an account after it.
inline constexpr std::string_view kUnbounded = "none", kDefaultMethod = "contact_frame",
                                  kSessionMethod = "shaped";

/// The virtual coupling of one port. Missing values become the largest passive ones.
struct CouplingConfig {
  std::optional<double> stiffness;  // k [N/m]; default 2 (b - b_c) / T
  std::optional<double> damping;    // b_c [N s/m]; default b - k T / 2, all that is left
  double mass = 0.05;               // [kg] of the tool, > 0
};

struct BoundingConfig {
  /// A method of the registry (core/bounding/method.hpp). The text must outlive the configuration:
  /// a literal, or the name in the registry.
  std::string_view mode = kDefaultMethod;
  Projection projection = Projection::joint;                // contact_frame only
  Storage storage = Storage::minimal;                       // contact_frame only
  PassivityReference reference = PassivityReference::zero;  // passivity_control* only
  CouplingConfig coupling{};                                // virtual_coupling only
  CouplingConfig coupling_rotation{{}, {}, 5e-5};           // [N m/rad], [N m s/rad], [kg m^2]
  double hand_damping = 1.5;  // a [N s/m] assumed damping of the hand; `credited` and `shaped` only
  double quantum = 0.0;       // [m] of the encoder; the same
  double stiffness = std::numeric_limits<double>::infinity();  // [N/m] of the stiffest surface,
                                                               // if it is known; the same
  double period = 1e-3;  // T [s], > 0: the longest intended hold time of one force
  double lag = 0.0;   // L [s] by which the motor follows its command, at most. 0 in a paper's law
  Damping damping{};  // B [N s/m]: the device's own, plus any operator credit. contact_frame and
                      // energy_tank need every direction damped, or none
  Damping rotational_damping{};      // B_r [N m s/rad]
  std::optional<double> c1{}, c2{};  // [N/m] translation, paper's modes; default b/T; 0 <= c2 <= c1
  std::optional<double> c1_rotation{}, c2_rotation{};           // [N m/rad] default b_r/T
  double max_force = std::numeric_limits<double>::infinity();   // [N], > 0: peak of the device
  double max_torque = std::numeric_limits<double>::infinity();  // [N m], >= 0
  bool rotation = false;  // false: torque is neither computed nor rendered

  /// T + 2 L [s]: a force that is held for T and follows its command by L is late by T/2 + L on
  /// average, as one that is held for so long and has no lag. The constants of every law take this.
  double reckoned_period() const noexcept { return period + 2.0 * lag; }
};

}  // namespace feltwire
