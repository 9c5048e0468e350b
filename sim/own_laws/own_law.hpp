#pragma once
// The door for bounding laws of users that are not compiled into the program: of a shared library,
// or of another process. They enter the registry of bounding methods like every other law.

#include <cstddef>
#include <memory>
#include <string>

#include "core/bounding/method.hpp"

namespace feltwire {

inline constexpr std::size_t kOwnLawMemory = 1024;  // [bytes] of one run of a law

/// A law of a user. Several threads call its functions, each with another memory. `memory` has
/// kOwnLawMemory bytes, aligned to 16, and is copied byte by byte. The functions may throw
/// std::runtime_error with what is wrong and the remedy: the law then renders no force any more.
class OwnLaw {
 public:
  virtual ~OwnLaw() = default;
  /// Begins a run with zeroed memory.
  virtual void reset(const BoundingConfig& device, std::byte* memory) = 0;
  /// The force that the law allows, which counts as held.
  virtual Command step(std::byte* memory, const BoundingStep& step) = 0;
  /// Another force was held than step() returned.
  virtual void set_held(std::byte* memory, const Command& held) = 0;
};

/// The fields of a BoundingMethod that a user chooses.
struct OwnLawEntry {
  std::string name{}, summary{};
  Promise promise = Promise::port;
  Faults kept_despite = kAllFaults;
  bool admits_reduction = true;
};

/// Adds the law to the registry for as long as the process runs. Call it before other threads use
/// the registry. Throws std::invalid_argument if the name is not valid or is taken.
void add_own_law(const OwnLawEntry& entry, std::unique_ptr<OwnLaw> law);

/// Throws std::runtime_error with the first error of a law: its name, the step, what is wrong and
/// the remedy. Call it after a study, before its results are used. Returns if there was none.
void check_own_laws();

}  // namespace feltwire
