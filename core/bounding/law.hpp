#pragma once
// A bounding law of any type, with its memory, as one value that is copied without the heap.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <type_traits>

#include "core/bounding/step.hpp"

namespace feltwire {

/// The command that a law allows, and whether the law has a debt of energy. With a debt it renders
/// no force.
template <class Real>
struct BasicLawAnswer {
  BasicCommand<Real> rendered;
  bool in_debt = false;
};

/// The values that a law adapts to the hand. It lowers each when the hand swings, and counts that.
struct HandCredit {
  double damping = 0.0;  // a [N s/m] of the hand, assumed for late forces; 0: none is assumed
  std::uint64_t steps_down = 0;
  double near_share = 1.0;  // of a force made at the device, that is rendered
  std::uint64_t near_steps_down = 0;
  /// [s] by which the motor seems to follow its commands later than was told: the hand swung as it
  /// does then, and the scene is asked so much farther ahead.
  double untold_lag = 0.0;
};

/// Holds a value of any type that has, all noexcept,
///   BasicCommand<Real> step(const BasicBoundingStep<Real>&)   and takes its result as held,
///   void set_held(const BasicCommand<Real>&)                  if another force was held,
/// and, if the law needs them,
///   bool in_debt() const                    it renders no force until a debt of energy is repaid,
///   void endow(Real energy)                 the next step may draw on energy [J] from elsewhere,
///   BasicProbe<Real> probe(displacement, rotation) const      the place to evaluate the scene,
///   void scene_changed()                    the surfaces changed: it forgets the old ones,
///   HandCredit hand_credit() const          the values that it adapts to the hand.
/// The steps are described at BasicBounding (core/bounding/bounding.hpp), which calls them.
template <class Real>
class BasicBoundingLaw {
 public:
  using Step = BasicBoundingStep<Real>;
  static constexpr std::size_t kLargest = 1120;  // [bytes] of a law

  template <class Law>
  requires(!std::same_as<Law, BasicBoundingLaw>)
      BasicBoundingLaw(const Law& law)  // NOLINT(google-explicit-constructor): a law is one
      : functions_(&kFunctionsOf<Law>) {
    static_assert(sizeof(Law) <= kLargest && alignof(Law) <= alignof(std::max_align_t),
                  "a law is held in place: make it smaller, or raise kLargest");
    static_assert(std::is_trivially_destructible_v<Law>, "a law holds numbers: nothing to free");
    new (memory_) Law(law);
  }
  BasicBoundingLaw(const BasicBoundingLaw& other) noexcept : functions_(other.functions_) {
    functions_->copy(other.memory_, memory_);
  }
  BasicBoundingLaw& operator=(const BasicBoundingLaw& other) noexcept {
    if (this == &other) return *this;
    functions_ = other.functions_;
    functions_->copy(other.memory_, memory_);
    return *this;
  }
  ~BasicBoundingLaw() = default;

  BasicLawAnswer<Real> step(const Step& s) noexcept { return functions_->step(memory_, s); }
  void set_held(const BasicCommand<Real>& held) noexcept { functions_->set_held(memory_, held); }
  /// Whether endow() has an effect.
  bool takes_endowment() const noexcept { return functions_->endow != nullptr; }
  void endow(Real energy) noexcept {
    if (takes_endowment()) functions_->endow(memory_, energy);
  }
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept {
    if (functions_->probe == nullptr) return {};
    return functions_->probe(memory_, displacement, rotation);
  }
  void scene_changed() noexcept {
    if (functions_->scene_changed != nullptr) functions_->scene_changed(memory_);
  }
  std::optional<HandCredit> hand_credit() const noexcept {
    if (functions_->hand_credit == nullptr) return std::nullopt;
    return functions_->hand_credit(memory_);
  }

 private:
  struct Functions {
    void (*copy)(const std::byte* from, std::byte* to) noexcept;
    BasicLawAnswer<Real> (*step)(std::byte*, const Step&) noexcept;
    void (*set_held)(std::byte*, const BasicCommand<Real>&) noexcept;
    // Null if the law does not have it.
    void (*endow)(std::byte*, Real) noexcept;
    BasicProbe<Real> (*probe)(const std::byte*, const Vector3<Real>&,
                              const Vector3<Real>&) noexcept;
    void (*scene_changed)(std::byte*) noexcept;
    HandCredit (*hand_credit)(const std::byte*) noexcept;
  };

  template <class Law>
  static Law& in(std::byte* memory) noexcept {
    return *std::launder(reinterpret_cast<Law*>(memory));
  }
  template <class Law>
  static const Law& in(const std::byte* memory) noexcept {
    return *std::launder(reinterpret_cast<const Law*>(memory));
  }

  template <class Law>
  static constexpr Functions functions_of() {
    static_assert(
        requires(Law law, Step s, BasicCommand<Real> c) {
          { law.step(s) }
          noexcept->std::same_as<BasicCommand<Real>>;
          { law.set_held(c) }
          noexcept;
        },
        "a law has step() and set_held(), both noexcept");
    Functions f{};
    f.copy = [](const std::byte* from, std::byte* to) noexcept { new (to) Law(in<Law>(from)); };
    f.step = [](std::byte* memory, const Step& s) noexcept {
      Law& law = in<Law>(memory);
      BasicLawAnswer<Real> answer{law.step(s), false};
      if constexpr (requires { law.in_debt(); }) answer.in_debt = law.in_debt();
      return answer;
    };
    f.set_held = [](std::byte* memory, const BasicCommand<Real>& held) noexcept {
      in<Law>(memory).set_held(held);
    };
    if constexpr (requires(Law law, Real energy) { law.endow(energy); })
      f.endow = [](std::byte* memory, Real energy) noexcept { in<Law>(memory).endow(energy); };
    if constexpr (requires(const Law law, Vector3<Real> v) { law.probe(v, v); })
      f.probe = [](const std::byte* memory, const Vector3<Real>& displacement,
                   const Vector3<Real>& rotation) noexcept {
        return in<Law>(memory).probe(displacement, rotation);
      };
    if constexpr (requires(Law law) { law.scene_changed(); })
      f.scene_changed = [](std::byte* memory) noexcept { in<Law>(memory).scene_changed(); };
    if constexpr (requires(const Law law) { law.hand_credit(); })
      f.hand_credit = [](const std::byte* memory) noexcept {
        return in<Law>(memory).hand_credit();
      };
    return f;
  }
  template <class Law>
  static constexpr Functions kFunctionsOf = functions_of<Law>();

  const Functions* functions_;
  alignas(std::max_align_t) std::byte memory_[kLargest];
};
using BoundingLaw = BasicBoundingLaw<double>;

}  // namespace feltwire
