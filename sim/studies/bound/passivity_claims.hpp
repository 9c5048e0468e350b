#pragma once
// A ledger that checks the energy promise of a bounding method (core/bounding/method.hpp).

#include <array>
#include <limits>

#include "core/bounding/method.hpp"

namespace feltwire {

/// The precision of an arithmetic.
struct Arithmetic {
  double epsilon = std::numeric_limits<double>::epsilon();   // 1 to the next number
  double least = std::numeric_limits<double>::denorm_min();  // the smallest number
  bool operator==(const Arithmetic&) const = default;
};
template <class Real>
inline constexpr Arithmetic kArithmetic = {std::numeric_limits<Real>::epsilon(),
                                           std::numeric_limits<Real>::denorm_min()};

/// The largest effect of rounding on an energy that passes through one step of a bound, in units of
/// epsilon.
/// From |F(n-1) + c dx| to the force that is held some 30 roundings of half an epsilon follow each
/// other (the constants b, T and c 3; normal 5; both channels' parts 6 each; length 4; reduction 2;
/// application 3), and an energy, a square, has twice the error of a force: 30, and a little.
inline constexpr double kEnergyRounding = 32.0;

/// The books of a port in long double. They use the values that were really held and the
/// displacements that the bound was really given, both after rounding to its arithmetic.
///
/// Within rounding means: the missing energy is not more than the sum over all samples so far of
///   kEnergyRounding * epsilon * condition * (exchanged in the sample + stored in the law)
/// because a law makes its storage anew every sample, out of its old storage and the exchanged
/// energy. In addition, the same number of smallest numbers may be missing: some forces or energies
/// are too small to have all digits.
/// `condition` is that of the damping matrix: largest over smallest eigenvalue.
class PromiseLedger {
 public:
  struct Setup {
    Promise promise = Promise::port;
    Damping damping{}, rotational_damping{};  // B of the real device
    double period = 1e-3;                     // T [s]
    bool keeps_all =
        false;  // the law stores all energy that it ever took in, not only that at stake
    Arithmetic arithmetic{};
    bool one_balance = false;  // Promise::port of force and torque together, as of an account
  };
  explicit PromiseLedger(const Setup& setup);

  /// The device moved while `held` acted on the hand for `hold_time` [s].
  void moved(const Command& held, const Vec3& displacement, const Vec3& rotation, double hold_time);
  /// A coupling's tool in one port: the scene's work on it in the last sample, and the energy in
  /// its spring and its mass [J].
  struct Tool {
    double work = 0.0, stored = 0.0;
  };
  void tool_moved(const Tool& translation, const Tool& rotation);
  /// `rendered` is held from now on. The command that it was made of and the movement before it are
  /// what an observer pairs.
  void rendered(const Command& rendered, const Command& commanded, const Vec3& displacement,
                const Vec3& rotation);

  /// Worst so far: the missing energy beyond the smallest numbers, relative to all that was
  /// exchanged.
  double error() const { return error_; }
  /// The largest effect of rounding, relative as well, where the error was worst.
  double rounding() const { return rounding_; }
  bool broken() const { return broken_; }

 private:
  struct Port {
    Damping damping;
    Mat3 inverse = Mat3::Zero();  // B^-1; zero without damping
    double condition = 1.0;
    std::array<long double, 3> balance{};  // [J] by axis, or [0] for all
    long double exchanged = 0.0L;          // [J] sum of magnitudes
    long double through = 0.0L;            // [J] sum of what passed through the arithmetic
    long double tiny = 0.0L;               // [J] sum of the values of the smallest numbers
    double tool_stored = 0.0;              // [J]
  };
  void exchange(Port& port, const Vec3& force, const Vec3& displacement, double hold_time);
  /// [J] The most that the hand can take from `held`: infinite without damping.
  long double at_stake(const Port& port, const Vec3& held) const;
  /// Takes up what the law stores now, for the limits of rounding. Returns what is at stake [J].
  long double stored(Port& port, const Vec3& force, const Vec3& displacement) const;
  void judge_together(const Command& rendered, const Vec3& displacement, const Vec3& rotation);
  void judge(Port& port, const Vec3& force, const Vec3& displacement);
  void judge(const Port& port, long double missing);

  Setup setup_;
  Port translation_, rotation_;
  double error_ = 0.0, rounding_ = 0.0;
  bool broken_ = false;
};

}  // namespace feltwire
