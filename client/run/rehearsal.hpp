#pragma once
// Simulated hands press on walls through the session's own law, to say what a hand will feel.

#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/hands/plant.hpp"
#include "client/servo/servo.hpp"

namespace feltwire {

/// A first press on one wall. A light finger (0.02 kg, 0.5 N s/m, 50 N/m) and a usual hand (0.1 kg,
/// 5 N s/m, 300 N/m) press with up to 3 N, or what the device can hold.
struct FirstPress {
  double wall = 0.0;   // [N/m] 0: there is none
  double share = 0.0;  // of the wall: force over depth at the handle, of the hand that feels less;
                       // at most 1
  double share_at_encoder = 0.0;  // the same at the encoder: more, if it is at the motor and the
                                  // transmission yields
  double swing = 0.0;  // [m] RMS of the handle about a straight line over half a second at the end,
                       // of the hand that swings more
  double stiffness() const noexcept { return share * wall; }  // [N/m] felt
  bool calm() const noexcept;
};

struct Rehearsal {
  double force = 0.0;         // [N] of the press
  double transmission = 0.0;  // [N/m] behind which the handle is; 0: rigid, or not known
  FirstPress scene;           // the scene's stiffest surface, or 1 kN/m if it is not known
  // Walls of 250 N/m to 40 kN/m are tried, up to the first on which a hand swings.
  FirstPress calm;          // the stiffest without swing
  FirstPress whole;         // the stiffest up to which each is felt to 0.9 or more
  FirstPress most;          // on which the most stiffness is felt
  bool mass_known = false;  // by the law; a device of 0.1 kg was simulated if not
  bool swings = false;      // on a wall that was tried
};

/// Presses a simulated device with this specification, whose motor is late by all of its
/// `actuation_lag` or `late_ticks`, as in a session whose replies all come. A third of its mass is
/// behind its `transmission_stiffness`, which is an assumption. Ticks come late by up to a tenth of
/// the period. Empty where the law is not known here: the server bounds, there is no
/// local model, the hand leads a robot or observes; or if it was stopped. `scene_stiffness` [N/m];
/// 0: not known. It takes about half a second of computing time, and asks `goes_on` some thousand
/// times meanwhile; false stops it. Throws what Servo's constructor throws.
std::optional<Rehearsal> rehearse(const DeviceSpec& spec, const SessionParameters& parameters,
                                  const ServoOptions& options, double scene_stiffness,
                                  const std::function<bool()>& goes_on = {});

/// Both hands, each with its own press on one wall of `stiffness` [N/m], in the order of the
/// comment on FirstPress. Empty and throws as rehearse().
std::vector<FirstPress> first_presses(const DeviceSpec& spec, const SessionParameters& parameters,
                                      const ServoOptions& options, double stiffness,
                                      const std::function<bool()>& goes_on = {});
/// [N] of a press on that device: 3 N, or what it can hold for long.
double press_force(const DeviceSpec& spec);
/// The transmission of a simulated device with this specification. A third of its mass is behind
/// it, and its damping is a twentieth of the critical one: both are assumptions.
Plant::Transmission assumed_plant_transmission(const DeviceSpec& spec);

/// Returns the line for the start of a run.
std::string rehearsal_text(const Rehearsal& rehearsal);

/// Rehearses beside a run and says the line on the standard error. It computes for a fifth of the
/// time in short pieces, at the lowest priority: a priority says nothing to other containers. It
/// does without where the system gives no thread.
class RehearsalThread {
 public:
  RehearsalThread(const DeviceSpec& spec, const SessionParameters& parameters,
                  const ServoOptions& options, double scene_stiffness) noexcept;
  /// Stops it if it is not done. Empty: it was not done, or there was nothing to say.
  std::optional<Rehearsal> finish() noexcept;

 private:
  std::optional<Rehearsal> found_;
  std::jthread thread_;
};

}  // namespace feltwire
