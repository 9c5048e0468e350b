#pragma once
// Two measures that the servo computes as it runs: the oscillation of the hand, and the displayed
// stiffness of the pressed surface.

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/centred_highpass.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// Oscillation [m]: RMS of the device's position along the contact's normal, less its centred
/// moving average over 51 ms (an odd number of servo samples; CentredHighPass, the lab's measure).
/// The normal is the direction of the newest elastic command. Windows that lie within one contact
/// count. A contact begins with a commanded elastic force of 0.005 N and ends when there has been
/// none for 25.5 ms. So a hand that chatters on a surface oscillates, and one that leaves it does
/// not.
///
/// Displayed stiffness [N/m]: the slope, by least squares, of the force held along the normal over
/// the pressing displacement, which is the way against the normal since the contact began. A tick
/// counts if the hand is deeper than ever before in this contact, moves along the normal rather
/// than across it, and holds 0.005 N or more. So only the way in counts, as in the lab. Contacts
/// are pooled, each about its own mean. So neither the place where a surface begins nor a delay,
/// which shifts all of a steady press, matters.
///
/// Both use the device's readings, encoder quanta included. The class allocates only when it is
/// made.
class FeelMetrics {
 public:
  /// `period` of the servo [s].
  explicit FeelMetrics(double period);

  /// Takes a tick. `displacement` [m] since the last one. `elastic` [N]: the scene's command on the
  /// hand; `held` [N]: the force on the hand from now on.
  void take(const Vec3& displacement, const Vec3& elastic, const Vec3& held) noexcept;
  /// The place of the device is not known: a contact ends.
  void lose() noexcept { end_contact(); }

  /// Sum of squares [m^2] and their number; oscillation() is the root of the mean. The values at
  /// two moments give the oscillation between them.
  struct Squares {
    double sum = 0.0;
    std::uint64_t count = 0;
    /// [m]; empty if nothing was measured.
    std::optional<double> rms() const;
    Squares since(const Squares& before) const { return {sum - before.sum, count - before.count}; }
  };
  const Squares& squares() const { return squares_; }
  std::optional<double> oscillation() const { return squares_.rms(); }
  /// Empty before 32 counted ticks that lie 20 um apart (standard deviation).
  std::optional<double> displayed_stiffness() const;

 private:
  void press(const Vec3& displacement, const Vec3& held) noexcept;
  void end_contact() noexcept;

  double period_;
  std::array<CentredHighPass, 3> axes_;
  bool in_contact_ = false;
  double without_force_ = 0.0;  // [s] since the last commanded force
  Vec3 normal_ = Vec3::Zero();
  Vec3 way_ = Vec3::Zero();             // [m] since the contact began
  Squares squares_, pending_;           // pending: since the last commanded force
  double depth_ = 0.0, deepest_ = 0.0;  // [m] pressing displacement
  // Means and centred sums: of this contact, and of all contacts.
  double ticks_ = 0.0, mean_depth_ = 0.0, mean_force_ = 0.0;
  double all_ticks_ = 0.0, depth_depth_ = 0.0, depth_force_ = 0.0;
};

}  // namespace feltwire
