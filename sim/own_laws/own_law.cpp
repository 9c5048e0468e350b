#include "sim/own_laws/own_law.hpp"

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "core/base/text.hpp"

namespace feltwire {
namespace {

struct AddedLaw {
  OwnLawEntry entry;
  std::unique_ptr<OwnLaw> law;
};

/// The laws stay where they are: the registry refers to their names.
std::deque<AddedLaw>& added_laws() {
  static std::deque<AddedLaw> laws;
  return laws;
}

/// The first error of all laws and threads.
struct FirstError {
  std::atomic<bool> set{false};  // read at every step
  std::mutex mutex;
  std::string text;
};
FirstError& first_error() {
  static FirstError error;
  return error;
}

void note_error(const AddedLaw& law, std::uint64_t step, const std::string& what) noexcept {
  FirstError& error = first_error();
  const std::scoped_lock lock(error.mutex);
  if (error.set) return;
  append(error.text, "law %s: step %llu: ", law.entry.name.c_str(),
         static_cast<unsigned long long>(step));
  error.text += what;
  error.set = true;
}

std::string vector_text(const Vec3& v) {
  std::string text;
  append(text, "(%g, %g, %g)", v.x(), v.y(), v.z());
  return text;
}

/// A run of a law, as a value of the registry (core/bounding/law.hpp).
struct RunOfOwnLaw {
  AddedLaw* law = nullptr;
  std::uint64_t steps = 0;
  alignas(std::max_align_t) std::byte memory[kOwnLawMemory] = {};

  Command step(const BoundingStep& s) noexcept {
    ++steps;
    if (first_error().set) return {};
    try {
      Command rendered = law->law->step(memory, s);
      if (rendered.finite()) return rendered;
      note_error(*law, steps,
                 "rendered the force " + vector_text(rendered.force()) + " N and the torque " +
                     vector_text(rendered.torque) + " N m for the command " +
                     vector_text(s.command.force()) + " N and the displacement " +
                     vector_text(s.displacement) +
                     " m; return finite numbers, zero where no force is allowed");
    } catch (const std::exception& error) {
      note_error(*law, steps, error.what());
    }
    return {};
  }
  void set_held(const Command& held) noexcept {
    if (first_error().set) return;
    try {
      law->law->set_held(memory, held);
    } catch (const std::exception& error) {
      note_error(*law, steps, error.what());
    }
  }
};

BoundingLaw make_own_law(const BoundingConfig& device) {
  for (AddedLaw& law : added_laws()) {
    if (law.entry.name != device.mode) continue;
    RunOfOwnLaw run{.law = &law};
    law.law->reset(device, run.memory);
    return run;
  }
  throw std::invalid_argument("there is no law '" + std::string(device.mode) + "'");
}

}  // namespace

void add_own_law(const OwnLawEntry& entry, std::unique_ptr<OwnLaw> law) {
  if (entry.name == "reference")
    throw std::invalid_argument(
        "bounding method 'reference': the tables have the surface itself under this name; take "
        "another");
  AddedLaw& added = added_laws().emplace_back(AddedLaw{entry, std::move(law)});
  try {
    add_bounding_method({.name = added.entry.name,
                         .summary = added.entry.summary,
                         .make = make_own_law,
                         .promise = added.entry.promise,
                         .kept_despite = added.entry.kept_despite,
                         .admits_reduction = added.entry.admits_reduction});
  } catch (...) {
    added_laws().pop_back();
    throw;
  }
}

void check_own_laws() {
  FirstError& error = first_error();
  const std::scoped_lock lock(error.mutex);
  if (error.set) throw std::runtime_error(error.text);
}

}  // namespace feltwire
