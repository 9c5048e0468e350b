#pragma once
// The registry of bounding methods: one entry each. Sessions, the wire, command lines and the
// laboratory know a method by its entry's name.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/bounding/config.hpp"
#include "core/bounding/law.hpp"

namespace feltwire {

/// The promise of a method about energy: a sum that must not become negative, for every hand. "At
/// stake" is the most that the hand can take while the force held now lasts for T: f' B^-1 f T / 4.
enum class Promise {
  none,             // nothing; the force is still finite, limited, and zero for what is not finite
  port,             // burned - delivered - at stake, whenever a force is rendered
  port_by_axis,     // the same on every axis by itself
  coupling,         // burned - delivered + work of the scene on the tool
  own_sum_by_axis,  // sum of F(n).dx(n) on every axis: the observer's, not the real port's
  own_sum           // the same over all axes, torque included
};
inline constexpr std::array<std::string_view, 6> kPromiseNames = {
    "none", "port", "port_by_axis", "coupling", "own_sum_by_axis", "own_sum"};

/// Faults of a session. Some methods promise nothing when they happen.
struct Faults {
  bool overlong_holds = false;  // held for longer than T, or held although not rendered
  bool reductions = false;      // less is held than was rendered: a limit, a fade
  bool unknown_inputs = false;  // the bound is told NaN or Inf
};
inline constexpr Faults kAllFaults{true, true, true};

/// Which options of BoundingConfig a method reads, beside period, damping and limits.
struct MethodOptions {
  bool c1_c2 = false, projection_storage = false, reference = false, coupling = false;
};

/// One method: its entry in the registry.
template <class Real>
struct BasicBoundingMethod {
  std::string_view name;     // a to z, 0 to 9 and _, at most kLongestMethodName; unique
  std::string_view summary;  // a line for --help. Both texts live as long as the program
  /// The law of a configuration, which the bound has checked. Throws std::invalid_argument for
  /// options that the law cannot keep its promise with.
  BasicBoundingLaw<Real> (*make)(const BoundingConfig&) = nullptr;
  bool research = true;  // for comparison in the laboratory; --help lists it after the others
  MethodOptions options{};
  Promise promise = Promise::none;
  Faults kept_despite{};   // the promise is kept although these happen
  bool keeps_all = false;  // it stores all energy that it ever took in, not only what is at stake
  /// A command that it lets through may be reduced further, by any factor, and the port stays
  /// passive when the bound is told (set_held). True of bounds on magnitudes from
  /// above, and where nothing is bounded.
  bool admits_reduction = false;
  /// It asks the scene elsewhere than at the device (Bounding::probe).
  bool moves_probe = false;
  /// It promises nothing and makes the force calm. The account behind it, at the client, makes the
  /// port passive (core/bounding/account.hpp).
  bool shapes = false;
  bool needs_every_axis_damped = false;  // or none at all
};
using BoundingMethod = BasicBoundingMethod<double>;

inline constexpr std::size_t kLongestMethodName = 64;  // [bytes]

/// All methods: the paper's, contact_frame, those of research, then what was added. An entry stays
/// where it is.
std::vector<const BoundingMethod*> bounding_methods();
std::vector<std::string_view> bounding_method_names();

/// The method of that name. Throws std::invalid_argument naming the choices when there is none.
const BoundingMethod& bounding_method(std::string_view name);

/// Adds a method, for this process: from here on it is found by its name like every other. Call it
/// before other threads use the registry, at the begin of main(). Throws std::invalid_argument when
/// the name is no name or is taken, or the entry has no law.
void add_bounding_method(const BoundingMethod& method);

/// For --help: the names, those of research last.
std::string bounding_method_choices();
/// For --help: a line for each method, its name and summary, those of research last.
std::string bounding_method_summaries();

/// Whether a method can stand at the server only: it asks the scene elsewhere than at the device. A
/// method that shapes asks the client's own local model there.
template <class Real>
bool stands_beside_scene(const BasicBoundingMethod<Real>& method) {
  return method.moves_probe && !method.shapes;
}

/// The promise that is left when these faults happen.
template <class Real>
Promise promise(const BasicBoundingMethod<Real>& method, const Faults& faults) {
  const Faults& kept = method.kept_despite;
  const bool broken = (faults.overlong_holds && !kept.overlong_holds) ||
                      (faults.reductions && !kept.reductions) ||
                      (faults.unknown_inputs && !kept.unknown_inputs);
  return broken ? Promise::none : method.promise;
}

}  // namespace feltwire
