#pragma once
// The registry of bounding methods: one entry each. Sessions, the wire, command lines and the
// laboratory know a method by its entry's name.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/bounding/bounding_config.hpp"
#include "core/bounding/law.hpp"

namespace feltwire {

/// The promise of a method about energy: a sum that must not become negative, for every hand. "At
/// stake" is the most that the hand can take while the force held now lasts for T: f' B^-1 f T / 4.
enum class Promise {
  none,             // nothing; the force is still finite and limited, and zero for NaN and Inf
  port,             // burned - delivered - at stake, whenever a force is rendered
  port_by_axis,     // the same for each axis separately
  coupling,         // burned - delivered + work of the scene on the tool
  own_sum_by_axis,  // sum of F(n).dx(n) on every axis: the observer's, not the real port's
  own_sum           // the same over all axes, torque included
};
inline constexpr std::array<std::string_view, 6> kPromiseNames = {
    "none", "port", "port_by_axis", "coupling", "own_sum_by_axis", "own_sum"};

/// Faults of a session. Some methods promise nothing if they happen.
struct Faults {
  bool overlong_holds = false;  // held for longer than T, or held although not rendered
  bool reductions = false;      // less is held than was rendered: a limit, a fade
  bool unknown_inputs = false;  // the bound gets NaN or Inf
};
inline constexpr Faults kAllFaults{true, true, true};

/// A method: its entry in the registry.
template <class Real>
struct BasicBoundingMethod {
  std::string_view name;     // a to z, 0 to 9 and _, at most kLongestMethodName; unique
  std::string_view summary;  // a line for --help. Both texts live as long as the program
  /// Makes the law of a configuration that the bound has checked. Throws std::invalid_argument for
  /// options with which the law cannot keep its promise.
  BasicBoundingLaw<Real> (*make)(const BoundingConfig&) = nullptr;
  bool research = true;   // for comparison in the laboratory; --help lists it after the others
  bool projects = false;  // it reads BoundingConfig::projection and storage
  Promise promise = Promise::none;
  Faults kept_despite{};   // the promise is kept although these happen
  bool keeps_all = false;  // it stores all energy that it ever took in, not only that at stake
  /// A command that it passes may be reduced further, by any factor, and the port stays
  /// passive if set_held() reports the reduction. True for bounds on magnitudes from
  /// above, and if nothing is bounded.
  bool admits_reduction = false;
  /// It evaluates the scene at a place other than the device (Bounding::probe).
  bool moves_probe = false;
  /// It promises nothing; it prevents oscillation. The account after it, at the client, makes the
  /// port passive (core/bounding/account.hpp).
  bool shapes = false;
  bool needs_every_axis_damped = false;  // or none at all
};
using BoundingMethod = BasicBoundingMethod<double>;

inline constexpr std::size_t kLongestMethodName = 64;  // [bytes]

/// All methods: the paper's, contact_frame, those of research, then added ones. An entry stays
/// in its place.
std::vector<const BoundingMethod*> bounding_methods();
std::vector<std::string_view> bounding_method_names();

/// The method of that name. Throws std::invalid_argument naming the choices if there is none.
const BoundingMethod& bounding_method(std::string_view name);

/// Adds a method for this process. From then on its name finds it, like every other method. Call it
/// before other threads use the registry, at the beginning of main(). Throws std::invalid_argument
/// if the name is not valid or is taken, or the entry has no law.
void add_bounding_method(const BoundingMethod& method);

/// For --help: the names, those of research last.
std::string bounding_method_choices();
/// For --help: a line for each method, its name and summary, those of research last.
std::string bounding_method_summaries();

/// Whether a method can only run at the server, because it evaluates the scene at a place other
/// than the device. A method that shapes evaluates the client's own local model there.
template <class Real>
bool stands_beside_scene(const BasicBoundingMethod<Real>& method) {
  return method.moves_probe && !method.shapes;
}

/// The promise that still holds if these faults happen.
template <class Real>
Promise promise(const BasicBoundingMethod<Real>& method, const Faults& faults) {
  const Faults& kept = method.kept_despite;
  const bool broken = (faults.overlong_holds && !kept.overlong_holds) ||
                      (faults.reductions && !kept.reductions) ||
                      (faults.unknown_inputs && !kept.unknown_inputs);
  return broken ? Promise::none : method.promise;
}

}  // namespace feltwire
